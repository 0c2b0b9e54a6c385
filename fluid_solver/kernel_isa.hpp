// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// The kernels stand in an inline namespace named after the instruction set they are compiled for
/// (element_kernels.cpp, drogue_kernels in cmake/targets.cmake), so that no two of them share a symbol.
/// Included elsewhere they are compiled as everything else is.
#ifndef DROGUE_ISA
#define DROGUE_ISA any_isa
#endif
