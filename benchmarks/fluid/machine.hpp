// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// What this machine could do at most, measured here and now by one core (a rank).
namespace drogue::bench {

/// Bytes a second of a = b + s c over arrays that no cache holds.
[[nodiscard]] double memory_bandwidth();

/// Floating-point operations a second of independent fused multiply-adds in registers, double precision.
[[nodiscard]] double arithmetic_peak();

} // namespace drogue::bench
