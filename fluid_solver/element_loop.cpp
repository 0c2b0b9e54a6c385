// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/element_loop.hpp"

#include "common/base/isa.hpp"
#include "fluid_solver/element_kernels.hpp"

namespace drogue::fluid {
namespace {

/// For the processor at hand.
const ElementKernels& kernels(int dimension) {
  static const ElementKernels* const plane[] = {&baseline::element_kernels_2d, &avx2::element_kernels_2d,
                                                &avx512::element_kernels_2d};
  static const ElementKernels* const space[] = {&baseline::element_kernels_3d, &avx2::element_kernels_3d,
                                                &avx512::element_kernels_3d};
  return *(dimension == 2 ? plane : space)[static_cast<int>(best_isa())];
}

} // namespace

template <int n>
void add_elements(const LocalElements& elements, const StepData& data, const FlowParameters& parameters,
                  std::span<const double, n> scale, std::span<double> residual,
                  la::BlockMatrix<n>* jacobian) noexcept {
  double block_scale[n * n];
  for (std::size_t j = 0; j < n; ++j)
    for (std::size_t i = 0; i < n; ++i) block_scale[j * n + i] = scale[i] * scale[j];
  const ElementKernels& all = kernels(elements.dimension);
  ElementKernels::Add<n> add = nullptr;
  if constexpr (n == 4)
    add = all.semi_discrete;
  else
    add = data.time_points == 2 ? all.space_time_2 : all.space_time_3;
  add(elements, data, parameters, block_scale, residual.data(), jacobian);
}

template void add_elements<4>(const LocalElements&, const StepData&, const FlowParameters&,
                              std::span<const double, 4>, std::span<double>, la::BlockMatrix<4>*) noexcept;
template void add_elements<8>(const LocalElements&, const StepData&, const FlowParameters&,
                              std::span<const double, 8>, std::span<double>, la::BlockMatrix<8>*) noexcept;

} // namespace drogue::fluid
