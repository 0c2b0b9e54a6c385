// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/isa.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>

namespace drogue {
namespace {

/// AVX2 with fused multiply-add, x86-64-v3; AVX-512 with its F, BW, CD, DQ and VL parts, x86-64-v4.
Isa of_processor() {
  __builtin_cpu_init();
  const bool v3 = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                  __builtin_cpu_supports("bmi") && __builtin_cpu_supports("bmi2");
  const bool v4 = v3 && __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512bw") &&
                  __builtin_cpu_supports("avx512cd") && __builtin_cpu_supports("avx512dq") &&
                  __builtin_cpu_supports("avx512vl");
  return v4 ? Isa::avx512 : v3 ? Isa::avx2 : Isa::baseline;
}

Isa allowed() {
  const char* wish = std::getenv("DROGUE_ISA");
  for (const Isa isa : {Isa::baseline, Isa::avx2})
    if (wish != nullptr && std::strcmp(wish, name(isa)) == 0) return isa;
  return Isa::avx512;
}

} // namespace

Isa best_isa() {
  static const Isa isa = std::min(of_processor(), allowed());
  return isa;
}

const char* name(Isa isa) {
  switch (isa) {
  case Isa::baseline:
    return "baseline";
  case Isa::avx2:
    return "avx2";
  case Isa::avx512:
    return "avx512";
  }
  return "";
}

} // namespace drogue
