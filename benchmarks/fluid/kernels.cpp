// SPDX-License-Identifier: GPL-3.0-or-later
#include "benchmarks/fluid/kernels.hpp"

#include <vector>

#include "benchmarks/fluid/machine.hpp"
#include "benchmarks/support/measure.hpp"
#include "common/la_krylov/block_matrix.hpp"
#include "fluid_solver/element_loop.hpp"
#include "fluid_solver/semi_discrete_element.hpp"
#include "fluid_solver/space_time_element.hpp"

namespace drogue::bench {
namespace {

using namespace fluid;

/// A number that counts the operations made with it: the arithmetic of an element, exactly. A square root or
/// a division counts as one.
struct Counted {
  static inline long operations = 0;
  double value = 0;
  Counted() = default;
  Counted(double v) : value(v) {} // NOLINT: as a double converts
  friend Counted operator+(Counted a, Counted b) { return ++operations, a.value + b.value; }
  friend Counted operator-(Counted a, Counted b) { return ++operations, a.value - b.value; }
  friend Counted operator*(Counted a, Counted b) { return ++operations, a.value * b.value; }
  friend Counted operator/(Counted a, Counted b) { return ++operations, a.value / b.value; }
  Counted operator-() const { return ++operations, -value; }
  Counted& operator+=(Counted b) { return *this = *this + b; }
  Counted& operator-=(Counted b) { return *this = *this - b; }
  Counted& operator*=(Counted b) { return *this = *this * b; }
  friend bool operator>(Counted a, Counted b) { return a.value > b.value; }
};

} // namespace
} // namespace drogue::bench

namespace drogue::fluid {
inline namespace DROGUE_ISA {
template <class Function>
[[nodiscard]] inline bench::Counted lanewise(bench::Counted a, Function f) noexcept {
  ++bench::Counted::operations;
  return f(a.value);
}
} // namespace DROGUE_ISA
} // namespace drogue::fluid

namespace drogue::bench {
namespace {

const FlowParameters parameters{
    .dt = 0.0032, .nu = 1.54e-4, .smagorinsky = 0.1, .lsic = true, .tau_dt = 0.0032};

/// Operations of one tetrahedron's residual and tangent.
template <int n>
double operations_of_element() {
  const StandardCoefficients rule{parameters};
  Counted r[4][n];
  const double corner[4][3] = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto ignore = [](int, int, const Counted*) {};
  Counted::operations = 0;
  if constexpr (n == 8) {
    SpaceTimeValues<3, Counted> in;
    for (int a = 0; a < 4; ++a)
      for (int d = 0; d < 3; ++d) in.x_n[a][d] = in.x_np1[a][d] = corner[a][d];
    SlabInstants<3, 2, Counted> s;
    space_time_residual(in, parameters, rule, r, s);
    space_time_tangent(s, parameters.dt, ignore);
  } else {
    SemiDiscreteValues<3, Counted> in;
    for (int a = 0; a < 4; ++a)
      for (int d = 0; d < 3; ++d) in.x[a][d] = corner[a][d];
    Instant<3, Counted> s;
    semi_discrete_residual(in, 1 / parameters.dt, parameters, rule, r, s);
    semi_discrete_tangent(s, 1 / parameters.dt, ignore);
  }
  return static_cast<double>(Counted::operations);
}

StepData step_data(const FluidMesh& mesh, int n) {
  StepData data;
  data.dt = parameters.dt;
  data.rate = 1 / parameters.dt;
  data.x_n = data.x_np1 = mesh.points;
  for (auto* v : {&data.u_n, &data.history, &data.f_n, &data.f_np1}) v->assign(mesh.points.size(), 0.0);
  data.unknowns.assign(static_cast<std::size_t>(mesh.node_count()) * static_cast<std::size_t>(n), 0.0);
  for (std::size_t i = 0; i < data.unknowns.size(); ++i)
    data.unknowns[i] = i % 4 == 2 ? 22 + std::sin(0.01 * static_cast<double>(i)) : 0.0;
  return data;
}

} // namespace

template <int n>
double kernel_rows(const FluidMesh& mesh, const std::string& name) {
  const la::RowRange own{0, mesh.node_count()};
  const la::LocalPattern pattern = la::local_pattern(mesh.graph, own);
  const LocalElements elements(mesh, own, pattern);
  const StepData data = step_data(mesh, n);
  const auto size = static_cast<std::size_t>(mesh.node_count()) * n;
  std::vector<double> scale(n, 1.0), residual(size), x(size, 1.0), y(size), defect(size / 4);
  la::BlockMatrix<n> A(pattern);
  la::BlockIlu<n> ilu(pattern);
  la::FourthRows<n> pressure(pattern);
  const auto assemble = [&](la::BlockMatrix<n>* matrix) {
    std::fill(residual.begin(), residual.end(), 0.0);
    add_elements<n>(elements, data, parameters, std::span<const double, n>(scale.data(), n), residual,
                    matrix);
  };
  // 1. assembly
  const double peak = arithmetic_peak();
  const double jacobian = least_processor_time(3, [&] { assemble(&A); });
  const double at_peak = operations_of_element<n>() * mesh.cell_count() / peak;
  row(name + "/equations", static_cast<double>(size), "count");
  row(name + "/operations_an_element", operations_of_element<n>(), "count");
  row(name + "/jacobian_assembly", 1e3 * jacobian, "ms");
  row(name + "/jacobian_assembly_over_arithmetic_peak", 100 * jacobian / at_peak, "percent");
  row(name + "/residual_assembly", 1e3 * least_processor_time(3, [&] { assemble(nullptr); }), "ms");
  // 2. a linear iteration: a product, a factor's solution, a defect of the pressure rows
  row(name + "/ilu_factorisation", 1e3 * least_processor_time(2, [&] { (void)ilu.factor(A); }), "ms");
  pressure.copy(A);
  const double bandwidth = memory_bandwidth();
  const double product = least_processor_time(5, [&] { A.multiply(x.data(), y.data()); });
  const double solution = least_processor_time(5, [&] { ilu.apply(x.data(), y.data()); });
  const double rows = least_processor_time(5, [&] { pressure.defect(x.data(), y.data(), defect.data()); });
  const double entries = static_cast<double>(pattern.column.size());
  const double bytes = entries * (n * n * (4 + 2 + 1) + 3 * 4) + 6.0 * 8 * static_cast<double>(size);
  row(name + "/product", 1e3 * product, "ms");
  row(name + "/ilu_solution", 1e3 * solution, "ms");
  row(name + "/pressure_rows", 1e3 * rows, "ms");
  row(name + "/iteration_without_amg", 1e3 * (product + solution + rows), "ms");
  row(name + "/iteration_without_amg_over_its_bytes", 100 * (product + solution + rows) * bandwidth / bytes,
      "percent");
  row(name + "/bytes_an_iteration", bytes / 1e6, "MB");
  return jacobian;
}

template double kernel_rows<4>(const FluidMesh&, const std::string&);
template double kernel_rows<8>(const FluidMesh&, const std::string&);

} // namespace drogue::bench
