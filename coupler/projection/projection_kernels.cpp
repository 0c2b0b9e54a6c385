// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once for each instruction set: drogue_kernels in cmake/targets.cmake.
#include "coupler/projection/projection_kernels.hpp"

#include <cmath>
#include <cstddef>

#include "common/base/vector_rows.hpp"

namespace drogue::projection::DROGUE_ISA {
namespace {

/// x, y, z and zero.
using Vec = Row<4>;

Vec vector_at(const double* x, std::int32_t node) {
  const double* at = x + 3 * static_cast<std::ptrdiff_t>(node);
  return Vec{at[0], at[1], at[2], 0};
}

/// (a cross b) with its components in the order z, x, y.
Vec turned_cross(Vec a, Vec b) {
  return a * __builtin_shufflevector(b, b, 1, 2, 0, 3) - __builtin_shufflevector(a, a, 1, 2, 0, 3) * b;
}
Vec turned_back(Vec a) {
  return __builtin_shufflevector(a, a, 1, 2, 0, 3);
}

/// The load's values in the three nodes, times twice the triangle's area.
struct OfPressure {
  static void load(const double* p, const std::int32_t* node, Vec area, Vec* G) {
    for (int b = 0; b < 3; ++b) G[b] = p[node[b]] * area;
  }
};
struct OfTraction {
  static void load(const double* t, const std::int32_t* node, Vec area, Vec* G) {
    const double twice = std::sqrt(area[0] * area[0] + area[1] * area[1] + area[2] * area[2]);
    for (int b = 0; b < 3; ++b) G[b] = twice * vector_at(t, node[b]);
  }
};

/// f_a += sum_b C_ab G_b. The sums over the triangle are those of its mass matrix, (1 + delta_bc) / 24.
template <class Load, bool moving>
FlatSums add_load(const FlatTriangles& t, const FlatFluid& fluid, const double* load, double* f) noexcept {
  Vec force{}, moment{}, power{};
  for (std::int32_t e = 0; e < t.count; ++e) {
    const std::int32_t* node = t.nodes + 3 * static_cast<std::ptrdiff_t>(e);
    Vec X[3], G[3];
    for (int b = 0; b < 3; ++b) X[b] = vector_at(fluid.points, node[b]);
    Load::load(load, node, turned_back(turned_cross(X[1] - X[0], X[2] - X[0])), G);
    const Vec whole = G[0] + G[1] + G[2];
    force += whole;
    for (int b = 0; b < 3; ++b) moment += turned_cross(X[b], G[b] + whole);
    if constexpr (moving)
      for (int b = 0; b < 3; ++b) power += vector_at(fluid.velocity, node[b]) * (G[b] + whole);
    const FlatTriangles::Rows& rows = t.rows[e];
    const std::int32_t* at = t.row_nodes + rows.first_node;
    const double* C = t.values + rows.first_value;
    for (std::int32_t a = 0; a < rows.count; ++a, C += 3)
      row_of<4>(f, at[a]) += C[0] * G[0] + C[1] * G[1] + C[2] * G[2];
  }
  moment = turned_back(moment);
  FlatSums sums;
  for (std::size_t k = 0; k < 3; ++k) {
    sums.force[k] = force[k] / 6;
    sums.moment[k] = moment[k] / 24;
    sums.power += power[k] / 24;
  }
  return sums;
}

template <class Load>
FlatSums add_load_of(const FlatTriangles& t, const FlatFluid& fluid, const double* load, double* f) noexcept {
  return fluid.velocity ? add_load<Load, true>(t, fluid, load, f) : add_load<Load, false>(t, fluid, load, f);
}

template <int lanes>
void multiply(const RowMatrix& A, const double* x, double* y) noexcept {
  for (std::int32_t i = 0; i < A.rows; ++i) {
    Row<lanes> sum{};
    for (std::int32_t k = A.first[i]; k < A.first[i + 1]; ++k)
      sum += A.value[k] * row_of<lanes>(x, A.column[k]);
    row_of<lanes>(y, i) = sum;
  }
}

} // namespace

const ProjectionKernels projection_kernels{add_load_of<OfPressure>, add_load_of<OfTraction>, multiply<4>,
                                           multiply<8>};

} // namespace drogue::projection::DROGUE_ISA
