// SPDX-License-Identifier: GPL-3.0-or-later
#include "participant/cpp/wire.hpp"

#include <numeric>

#include <gtest/gtest.h>

namespace drogue::wire {
namespace {

/// Frames over bytes that others own, which need not begin where a double may.
Frames moved(const Frames& frames, std::vector<char>& bytes, std::size_t offset) {
  Frames result;
  for (const zmq::message_t& frame : frames) result.emplace_back(frame.data(), frame.size());
  bytes.assign(offset, '\0');
  const char* const begin = frames[2].data<char>();
  bytes.insert(bytes.end(), begin, begin + frames[2].size());
  result[2].rebuild(
      bytes.data() + offset, frames[2].size(), [](void*, void*) {}, nullptr);
  return result;
}

TEST(Wire, TakesArraysFromFramesThatBeginAnywhere) {
  Message message;
  message.envelope.mutable_iterate();
  std::vector<double> values(3000);
  std::iota(values.begin(), values.end(), 0.1);
  message.floats["force"] = {{1000, 3}, values};
  const Frames frames = encode(std::move(message));
  for (std::size_t offset = 0; offset < 16; ++offset) {
    std::vector<char> bytes;
    const Frames at_offset = moved(frames, bytes, offset);
    const auto decoded = decode(at_offset);
    ASSERT_TRUE(decoded.ok()) << decoded.error().message;
    EXPECT_EQ(decoded->floats.at("force").values, values) << offset;
    bytes.back() = static_cast<char>(bytes.back() + 1);
    EXPECT_FALSE(decode(at_offset).ok()) << offset;
  }
}

} // namespace
} // namespace drogue::wire
