// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/isa.hpp"
#include "coupler/projection/projection_kernels.hpp"

namespace drogue::projection {

const ProjectionKernels& projection_kernels() {
  static const ProjectionKernels* const of[] = {&baseline::projection_kernels, &avx2::projection_kernels,
                                                &avx512::projection_kernels};
  return *of[static_cast<int>(best_isa())];
}

} // namespace drogue::projection
