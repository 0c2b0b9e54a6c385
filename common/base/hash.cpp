// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/hash.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include "common/base/isa.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#endif

namespace drogue {
namespace {

std::uint32_t zlib_crc32(const void* bytes, std::size_t size, std::uint32_t before) {
  return static_cast<std::uint32_t>(::crc32_z(before, static_cast<const unsigned char*>(bytes), size));
}

#if defined(__x86_64__)
constexpr std::size_t registers = 8;          ///< as many as hide the latency of a multiplication
constexpr std::size_t block = registers * 16; ///< bytes
constexpr std::size_t smallest_fold = 256;
constexpr std::size_t wide_registers = 4;               ///< of 64 bytes
constexpr std::size_t wide_block = wide_registers * 64; ///< bytes
constexpr std::size_t smallest_wide_fold = 1024;

/// Moves a register over the next `distance` bits of the message without changing the remainder: its two
/// halves are multiplied by x^(distance + 32) and x^(distance - 32) modulo the polynomial, bit-reflected
/// [gopal2009, "Fold by 4"].
__attribute__((target("pclmul,sse4.1"))) __m128i fold(__m128i x, __m128i constants, __m128i next) {
  return _mm_xor_si128(next, _mm_xor_si128(_mm_clmulepi64_si128(x, constants, 0x00),
                                           _mm_clmulepi64_si128(x, constants, 0x11)));
}

/// Folds all registers into the last one. What is left then has the remainder of all that was folded into
/// it, with nothing before it.
template <std::size_t n>
__attribute__((target("pclmul,sse4.1"))) std::uint32_t remainder(__m128i (&x)[n]) {
  const __m128i over_128 = _mm_set_epi64x(0x0ccaa009e, 0x1751997d0);
  for (std::size_t i = 1; i < n; ++i) x[i] = fold(x[i - 1], over_128, x[i]);
  return zlib_crc32(&x[n - 1], sizeof(__m128i), 0xffffffffU);
}

/// @pre bytes.size() is a multiple of `block`, and not zero
__attribute__((target("pclmul,sse4.1"))) std::uint32_t folded_crc32(std::span<const std::byte> bytes,
                                                                    std::uint32_t before) {
  const __m128i over_1024 = _mm_set_epi64x(0x14a7fe880, 0x1e88ef372);
  const auto* next = reinterpret_cast<const __m128i*>(bytes.data());
  const auto* const end = next + bytes.size() / sizeof(__m128i);
  __m128i x[registers];
  for (__m128i& register_ : x) register_ = _mm_loadu_si128(next++);
  x[0] = _mm_xor_si128(x[0], _mm_cvtsi32_si128(static_cast<int>(~before)));
  for (; next != end; next += registers)
    for (std::size_t i = 0; i < registers; ++i) x[i] = fold(x[i], over_1024, _mm_loadu_si128(next + i));
  return remainder(x);
}

__attribute__((target("avx512f"))) __m512i in_all_quarters(std::int64_t upper, std::int64_t lower) {
  return _mm512_set_epi64(upper, lower, upper, lower, upper, lower, upper, lower);
}

/// fold() of four registers at once.
__attribute__((target("avx512f,vpclmulqdq"))) __m512i fold(__m512i x, __m512i constants, __m512i next) {
  constexpr int exclusive_or_of_three = 0x96;
  return _mm512_ternarylogic_epi64(next, _mm512_clmulepi64_epi128(x, constants, 0x00),
                                   _mm512_clmulepi64_epi128(x, constants, 0x11), exclusive_or_of_three);
}

/// @pre bytes.size() is a multiple of `wide_block`, and not zero
__attribute__((target("avx512f,vpclmulqdq,pclmul,sse4.1"))) std::uint32_t
wide_folded_crc32(std::span<const std::byte> bytes, std::uint32_t before) {
  const __m512i over_2048 = in_all_quarters(0x1322d1430, 0x11542778a);
  const __m512i over_512 = in_all_quarters(0x1c6e41596, 0x154442bd4);
  const std::byte* next = bytes.data();
  const std::byte* const end = next + bytes.size();
  __m512i x[wide_registers];
  for (std::size_t i = 0; i < wide_registers; ++i, next += sizeof(__m512i)) x[i] = _mm512_loadu_si512(next);
  x[0] = _mm512_xor_si512(x[0], _mm512_zextsi128_si512(_mm_cvtsi32_si128(static_cast<int>(~before))));
  for (; next != end; next += wide_block)
    for (std::size_t i = 0; i < wide_registers; ++i)
      x[i] = fold(x[i], over_2048, _mm512_loadu_si512(next + i * sizeof(__m512i)));
  for (std::size_t i = 1; i < wide_registers; ++i) x[i] = fold(x[i - 1], over_512, x[i]);
  __m128i quarters[4];
  _mm512_storeu_si512(quarters, x[wide_registers - 1]);
  return remainder(quarters);
}
#endif

} // namespace

void Hash::add(std::span<const std::byte> bytes) {
  for (const std::byte b : bytes) state_ = (state_ ^ static_cast<std::uint64_t>(b)) * 1099511628211ULL;
}

std::string Hash::text() const {
  return fmt::format("{:016x}", state_);
}

std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before) {
#if defined(__x86_64__)
  static const bool folds = __builtin_cpu_supports("pclmul") != 0 && __builtin_cpu_supports("sse4.1") != 0;
  static const bool folds_wide =
      folds && best_isa() == Isa::avx512 && __builtin_cpu_supports("vpclmulqdq") != 0;
  if (folds_wide && bytes.size() >= smallest_wide_fold) {
    const std::size_t whole = bytes.size() / wide_block * wide_block;
    before = wide_folded_crc32(bytes.first(whole), before);
    bytes = bytes.subspan(whole);
  }
  if (folds && bytes.size() >= smallest_fold) {
    const std::size_t whole = bytes.size() / block * block;
    before = folded_crc32(bytes.first(whole), before);
    bytes = bytes.subspan(whole);
  }
#endif
  return zlib_crc32(bytes.data(), bytes.size(), before);
}

} // namespace drogue
