// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "common/base/result.hpp"

/// Turns the failure of a PETSc call into an Error of the enclosing function.
#define DROGUE_PETSC(call)                                                                                   \
  do {                                                                                                       \
    if (const auto drogue_petsc_code = (call); drogue_petsc_code != 0)                                       \
      return ::drogue::internal_error("PETSc error {} in {}", static_cast<int>(drogue_petsc_code), #call);   \
  } while (false)
