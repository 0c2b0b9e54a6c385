// SPDX-License-Identifier: GPL-3.0-or-later
// Messages as they come from a socket. Input: frames, each a length of two bytes (little-endian) and its
// bytes. What is taken must come through encoding and decoding once more.
#include <cstdlib>
#include <vector>

#include "participant/cpp/wire.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  drogue::wire::Frames frames;
  while (size >= 2 && frames.size() < 70) {
    const std::size_t length = std::min<std::size_t>(data[0] + 256U * data[1], size - 2);
    frames.emplace_back(data + 2, length);
    data += 2 + length;
    size -= 2 + length;
  }
  const auto message = drogue::wire::decode(frames);
  if (message && !drogue::wire::decode(drogue::wire::encode(*message))) std::abort();
  return 0;
}
