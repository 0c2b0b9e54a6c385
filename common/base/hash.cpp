// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/base/hash.hpp"

#include <fmt/format.h>
#include <zlib.h>

namespace drogue {

void Hash::add(std::span<const std::byte> bytes) {
  for (const std::byte b : bytes) state_ = (state_ ^ static_cast<std::uint64_t>(b)) * 1099511628211ULL;
}

std::string Hash::text() const {
  return fmt::format("{:016x}", state_);
}

std::uint32_t crc32(std::span<const std::byte> bytes) {
  return static_cast<std::uint32_t>(
      ::crc32_z(0, reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

} // namespace drogue
