// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

namespace drogue {

/// Instruction sets for which kernels are compiled (cmake/targets.cmake, drogue_kernels): one binary runs on
/// any x86-64 and uses what the processor has.
enum class Isa { baseline, avx2, avx512 };

/// The best that this processor has; less when the environment variable DROGUE_ISA says baseline or avx2.
/// Decided once in a process.
[[nodiscard]] Isa best_isa();

[[nodiscard]] const char* name(Isa isa);

} // namespace drogue
