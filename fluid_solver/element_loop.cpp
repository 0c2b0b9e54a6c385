// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/element_loop.hpp"

#include "fluid_solver/batch.hpp"
#include "fluid_solver/semi_discrete_element.hpp"
#include "fluid_solver/space_time_element.hpp"

namespace drogue::fluid {
namespace {

/// Lane l of to[a][i] from from[n nodes[4 l + a] + i].
template <int n>
inline void gather(const std::int32_t* nodes, const double* from, Batch to[4][n]) noexcept {
  for (int l = 0; l < batch_size; ++l)
    for (int a = 0; a < 4; ++a) {
      const double* values = from + static_cast<std::size_t>(nodes[4 * l + a]) * n;
      for (int i = 0; i < n; ++i) to[a][i][l] = values[i];
    }
}

template <int n>
inline void scatter(const std::int32_t* rows, const Batch from[4][n], double* residual) noexcept {
  for (int l = 0; l < batch_size; ++l)
    for (int a = 0; a < 4; ++a) {
      if (rows[4 * l + a] < 0) continue;
      double* to = residual + static_cast<std::size_t>(rows[4 * l + a]) * n;
      for (int i = 0; i < n; ++i) to[i] += from[a][i][l];
    }
}

/// Adds block (a, b) of eight elements to the matrix.
template <int n>
struct MatrixSink {
  const std::int32_t* entry;
  const double* scale; ///< {n * n}
  la::BlockMatrix<n>* matrix;

  void operator()(int a, int b, const Batch* block) const noexcept {
    alignas(64) double lanes[n * n * batch_size];
    for (int q = 0; q < n * n; ++q) {
      const Batch scaled = block[q] * scale[q];
      __builtin_memcpy(lanes + q * batch_size, &scaled, sizeof(scaled));
    }
    for (int l = 0; l < batch_size; ++l) {
      const std::int32_t position = entry[16 * l + 4 * a + b];
      if (position < 0) continue;
      float* to = matrix->block(position);
      for (int q = 0; q < n * n; ++q) to[q] += static_cast<float>(lanes[q * batch_size + l]);
    }
  }
};

inline void load(const StepData& data, const std::int32_t* nodes, SemiDiscreteValues<Batch>& in) noexcept {
  gather<3>(nodes, data.x_np1.data(), in.x);
  gather<3>(nodes, data.u_n.data(), in.u_n);
  gather<3>(nodes, data.f_np1.data(), in.f);
  gather<4>(nodes, data.unknowns.data(), in.w);
}

inline void load(const StepData& data, const std::int32_t* nodes, SpaceTimeValues<Batch>& in) noexcept {
  gather<3>(nodes, data.x_n.data(), in.x_n);
  gather<3>(nodes, data.x_np1.data(), in.x_np1);
  gather<3>(nodes, data.u_n.data(), in.u_n);
  gather<3>(nodes, data.f_n.data(), in.f_n);
  gather<3>(nodes, data.f_np1.data(), in.f_np1);
  gather<8>(nodes, data.unknowns.data(), in.w);
}

template <bool tangent, class Sink>
inline void element(const SemiDiscreteValues<Batch>& in, double dt, const StandardCoefficients& rule,
                    Batch residual[4][4], Sink&& sink) noexcept {
  semi_discrete_element<tangent>(in, dt, rule, residual, sink);
}
template <bool tangent, class Sink>
inline void element(const SpaceTimeValues<Batch>& in, double dt, const StandardCoefficients& rule,
                    Batch residual[4][8], Sink&& sink) noexcept {
  space_time_element<tangent>(in, dt, rule, residual, sink);
}

template <int n>
struct ValuesOf {
  using type = SpaceTimeValues<Batch>;
};
template <>
struct ValuesOf<4> {
  using type = SemiDiscreteValues<Batch>;
};

} // namespace

template <int n>
void add_elements(const LocalElements& elements, const StepData& data, const FlowParameters& parameters,
                  std::span<const double, n> scale, std::span<double> residual,
                  la::BlockMatrix<n>* jacobian) noexcept {
  const StandardCoefficients rule{parameters};
  double block_scale[n * n];
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i) block_scale[j * n + i] = scale[i] * scale[j];
  for (std::int32_t k = 0; k < elements.batches; ++k) {
    const auto first = static_cast<std::size_t>(k) * batch_size;
    typename ValuesOf<n>::type in;
    load(data, elements.node.data() + 4 * first, in);
    Batch r[4][n];
    if (jacobian != nullptr)
      element<true>(in, data.dt, rule, r,
                    MatrixSink<n>{elements.entry.data() + 16 * first, block_scale, jacobian});
    else
      element<false>(in, data.dt, rule, r, [](int, int, const Batch*) noexcept {});
    scatter<n>(elements.row.data() + 4 * first, r, residual.data());
  }
}

template void add_elements<4>(const LocalElements&, const StepData&, const FlowParameters&,
                              std::span<const double, 4>, std::span<double>, la::BlockMatrix<4>*) noexcept;
template void add_elements<8>(const LocalElements&, const StepData&, const FlowParameters&,
                              std::span<const double, 8>, std::span<double>, la::BlockMatrix<8>*) noexcept;

} // namespace drogue::fluid
