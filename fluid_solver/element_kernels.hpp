// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/la_krylov/block_matrix.hpp"
#include "fluid_solver/element_loop.hpp"
#include "fluid_solver/flow_parameters.hpp"
#include "fluid_solver/step_data.hpp"

namespace drogue::fluid {

/// The element loops of one dimension, compiled for one instruction set; block_scale {unknowns * unknowns} as
/// in add_elements.
struct ElementKernels {
  template <int unknowns>
  using Add = void (*)(const LocalElements& elements, const StepData& data, const FlowParameters& parameters,
                       const double* block_scale, double* residual,
                       la::BlockMatrix<unknowns>* jacobian) noexcept;
  Add<4> semi_discrete;
  Add<8> space_time_2; ///< two points in time
  Add<8> space_time_3;
};

inline namespace baseline {
extern const ElementKernels element_kernels_2d, element_kernels_3d;
}
inline namespace avx2 {
extern const ElementKernels element_kernels_2d, element_kernels_3d;
}
inline namespace avx512 {
extern const ElementKernels element_kernels_2d, element_kernels_3d;
}

} // namespace drogue::fluid
