// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>

namespace drogue {

/// FNV-1a, 64 bit, over everything given to `add`: identifies meshes and configs, not meant against
/// attackers.
class Hash {
 public:
  void add(std::span<const std::byte> bytes);
  void add(std::string_view text) { add(std::as_bytes(std::span(text.data(), text.size()))); }
  template <class T>
  void add(std::span<const T> values) {
    add(std::as_bytes(values));
  }
  /// Sixteen hexadecimal digits.
  [[nodiscard]] std::string text() const;

 private:
  std::uint64_t state_ = 14695981039346656037ULL;
};

/// CRC-32 (ISO-HDLC, as zlib): the checksum of array frames. `before`: that of the bytes before these.
[[nodiscard]] std::uint32_t crc32(std::span<const std::byte> bytes, std::uint32_t before = 0);

} // namespace drogue
