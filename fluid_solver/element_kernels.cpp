// SPDX-License-Identifier: GPL-3.0-or-later
// Compiled once for each instruction set: drogue_kernels in cmake/targets.cmake.
#include "fluid_solver/element_kernels.hpp"

#include <algorithm>
#include <cstring>

#include "fluid_solver/batch.hpp"
#include "fluid_solver/semi_discrete_element.hpp"
#include "fluid_solver/space_time_element.hpp"

namespace drogue::fluid {
inline namespace DROGUE_ISA {
namespace {

/// Lane l of to[a][i] from from[stride nodes[(dim + 1) l + a] + i], i < n.
template <int dim, int n, int stride>
inline void gather(const std::int32_t* nodes, const double* from, Batch to[dim + 1][n]) noexcept {
  for (int l = 0; l < batch_size; ++l)
    for (int a = 0; a <= dim; ++a) {
      const double* values = from + static_cast<std::size_t>(nodes[(dim + 1) * l + a]) * stride;
      for (int i = 0; i < n; ++i) to[a][i][l] = values[i];
    }
}

template <int dim, int n>
inline void scatter(const std::int32_t* rows, const Batch from[dim + 1][n], double* residual) noexcept {
  for (int l = 0; l < batch_size; ++l)
    for (int a = 0; a <= dim; ++a) {
      const std::int32_t row = rows[(dim + 1) * l + a];
      if (row < 0) continue;
      double* to = residual + static_cast<std::size_t>(row) * n;
      for (int i = 0; i < n; ++i) to[i] += from[a][i][l];
    }
}

using Eight = float __attribute__((vector_size(32)));

/// Turns eight rows of eight into eight columns.
inline void transpose(Eight r[8]) noexcept {
  Eight t[8];
  Eight u[8];
  for (int k = 0; k < 8; k += 2) {
    t[k] = __builtin_shufflevector(r[k], r[k + 1], 0, 8, 1, 9, 4, 12, 5, 13);
    t[k + 1] = __builtin_shufflevector(r[k], r[k + 1], 2, 10, 3, 11, 6, 14, 7, 15);
  }
  for (int k = 0; k < 8; k += 4)
    for (int h = 0; h < 2; ++h) {
      u[k + 2 * h] = __builtin_shufflevector(t[k + h], t[k + h + 2], 0, 1, 8, 9, 4, 5, 12, 13);
      u[k + 2 * h + 1] = __builtin_shufflevector(t[k + h], t[k + h + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  for (int k = 0; k < 4; ++k) {
    r[k] = __builtin_shufflevector(u[k], u[k + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    r[k + 4] = __builtin_shufflevector(u[k], u[k + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
}

/// Adds block (a, b) of sixteen elements to the matrix: eight scalars of a block at a time, transposed so
/// that those of an element lie side by side. Where an element comes first its values replace the former
/// ones. Meanwhile the blocks of the next sixteen are brought near.
template <int dim, int n>
struct MatrixSink {
  const std::int32_t* entry;
  const std::int32_t* next; ///< entry of the next sixteen elements
  const float* scale;       ///< {n * n}
  la::BlockMatrix<n>* matrix;

  void operator()(int a, int b, const Floats* block) const noexcept {
    constexpr int nodes = dim + 1;
    constexpr int line = 16; // floats
    alignas(64) static constexpr float zero[n * n] = {};
    alignas(64) float nowhere[n * n]; // for rows of other ranks
    for (int half = 0; half < 2; ++half) {
      const float* from[batch_size];
      float* to[batch_size];
      for (int l = 0; l < batch_size; ++l) {
        const int pair = nodes * (nodes * (batch_size * half + l) + a) + b;
        const std::int32_t place = entry[pair];
        to[l] = place < 0 ? nowhere : matrix->block(place >> 1);
        from[l] = (place & 1) != 0 ? zero : to[l];
        const float* soon = matrix->block(std::max(next[pair], 0) >> 1);
        for (int i = 0; i < n * n; i += line) __builtin_prefetch(soon + i, 1);
      }
      for (int q = 0; q < n * n; q += 8) {
        Eight rows[8];
        for (int k = 0; k < 8; ++k)
          std::memcpy(&rows[k], reinterpret_cast<const float*>(block + q + k) + 8 * half, sizeof(Eight));
        transpose(rows);
        Eight factor;
        std::memcpy(&factor, scale + q, sizeof(factor));
        for (int l = 0; l < batch_size; ++l) {
          Eight sum;
          std::memcpy(&sum, from[l] + q, sizeof(sum));
          sum += rows[l] * factor;
          std::memcpy(to[l] + q, &sum, sizeof(sum));
        }
      }
    }
  }
};

template <int dim>
inline void load(const StepData& data, const std::int32_t* nodes,
                 SemiDiscreteValues<dim, Batch>& in) noexcept {
  gather<dim, dim, 3>(nodes, data.x_np1.data(), in.x);
  gather<dim, dim, 3>(nodes, data.history.data(), in.history);
  gather<dim, dim, 3>(nodes, data.f_np1.data(), in.f);
  gather<dim, 4, 4>(nodes, data.unknowns.data(), in.w);
  if (!data.stress_np1.empty())
    gather<dim, stress_components<dim>, 6>(nodes, data.stress_np1.data(), in.stress);
}

template <int dim>
inline void load(const StepData& data, const std::int32_t* nodes, SpaceTimeValues<dim, Batch>& in) noexcept {
  gather<dim, dim, 3>(nodes, data.x_n.data(), in.x_n);
  gather<dim, dim, 3>(nodes, data.x_np1.data(), in.x_np1);
  gather<dim, dim, 3>(nodes, data.u_n.data(), in.u_n);
  gather<dim, dim, 3>(nodes, data.f_n.data(), in.f_n);
  gather<dim, dim, 3>(nodes, data.f_np1.data(), in.f_np1);
  gather<dim, 8, 8>(nodes, data.unknowns.data(), in.w);
  if (data.stress_np1.empty()) return;
  gather<dim, stress_components<dim>, 6>(nodes, data.stress_n.data(), in.stress_n);
  gather<dim, stress_components<dim>, 6>(nodes, data.stress_np1.data(), in.stress_np1);
}

/// What a formulation adds up on an element; time_points: quadrature points in time of DSD/SST.
template <int dim, int unknowns, int time_points>
struct Element;

template <int dim>
struct Element<dim, 4, 1> {
  using Values = SemiDiscreteValues<dim, Batch>;
  template <class Real>
  using Known = Instant<dim, Real>; ///< what the residual leaves for the tangent
  static void residual(const Values& in, const StepData& data, const StandardCoefficients& rule,
                       Batch r[dim + 1][4], Known<Batch>& known) noexcept {
    semi_discrete_residual(in, data.rate, rule.parameters, rule, r, known);
  }
  template <class Sink>
  static void tangent(const Known<Floats>& known, const StepData& data, Sink&& sink) noexcept {
    semi_discrete_tangent(known, data.rate, sink);
  }
};
template <int dim, int time_points>
struct Element<dim, 8, time_points> {
  using Values = SpaceTimeValues<dim, Batch>;
  template <class Real>
  using Known = SlabInstants<dim, time_points, Real>;
  static void residual(const Values& in, const StepData&, const StandardCoefficients& rule,
                       Batch r[dim + 1][8], Known<Batch>& known) noexcept {
    space_time_residual<time_points>(in, rule.parameters, rule, r, known);
  }
  template <class Sink>
  static void tangent(const Known<Floats>& known, const StepData& data, Sink&& sink) noexcept {
    space_time_tangent(known, data.dt, sink);
  }
};

/// Residuals of two batches, then their tangents together.
template <int dim, int n, int time_points>
void add_all(const LocalElements& elements, const StepData& data, const FlowParameters& parameters,
             const double* block_scale, double* residual, la::BlockMatrix<n>* jacobian) noexcept {
  const StandardCoefficients rule{parameters};
  using Kernel = Element<dim, n, time_points>;
  constexpr std::size_t nodes = dim + 1;
  constexpr std::size_t pairs = nodes * nodes;
  alignas(64) float scale[n * n];
  for (int i = 0; i < n * n; ++i) scale[i] = static_cast<float>(block_scale[i]);
  typename Kernel::template Known<Floats> narrowed;
  for (std::int32_t k = 0; k < elements.batches; ++k) {
    const auto first = static_cast<std::size_t>(k) * batch_size;
    typename Kernel::Values in;
    load<dim>(data, elements.node.data() + nodes * first, in);
    Batch r[nodes][n];
    typename Kernel::template Known<Batch> known;
    Kernel::residual(in, data, rule, r, known);
    scatter<dim, n>(elements.row.data() + nodes * first, r, residual);
    if (jacobian == nullptr) continue;
    narrow(known, k % 2, narrowed);
    if (k % 2 == 0) continue;
    const std::int32_t* entry = elements.entry.data() + pairs * (first - batch_size);
    const std::int32_t* next = k + 1 < elements.batches ? entry + pairs * 2 * batch_size : entry;
    Kernel::tangent(narrowed, data, MatrixSink<dim, n>{entry, next, scale, jacobian});
  }
}

template <int dim>
constexpr ElementKernels kernels_of{add_all<dim, 4, 1>, add_all<dim, 8, 2>, add_all<dim, 8, 3>};

} // namespace

const ElementKernels element_kernels_2d = kernels_of<2>;
const ElementKernels element_kernels_3d = kernels_of<3>;

} // namespace DROGUE_ISA
} // namespace drogue::fluid
