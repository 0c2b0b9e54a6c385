// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <vector>

#include "common/base/hash.hpp"
#include "common/base/nearest.hpp"
#include "common/base/result.hpp"

namespace drogue {
namespace {

std::string fnv(std::string_view text) {
  Hash hash;
  hash.add(text);
  return hash.text();
}

std::span<const std::byte> bytes(std::string_view text) {
  return std::as_bytes(std::span(text.data(), text.size()));
}

/// Reference values: the test vectors published with the FNV hash.
TEST(Hash, AgreesWithThePublishedVectors) {
  EXPECT_EQ(fnv(""), "cbf29ce484222325");
  EXPECT_EQ(fnv("a"), "af63dc4c8601ec8c");
  EXPECT_EQ(fnv("foobar"), "85944171f73967e8");
}

TEST(Hash, DependsOnOrderAndOnEveryBit) {
  const std::vector<double> values = {1, 2, 0.0};
  std::vector<double> swapped = {2, 1, 0.0}, negative_zero = {1, 2, -0.0};
  const auto of = [](const std::vector<double>& v) {
    Hash hash;
    hash.add(std::span<const double>(v));
    return hash.text();
  };
  EXPECT_EQ(of(values), of(std::vector<double>(values)));
  EXPECT_NE(of(values), of(swapped));
  EXPECT_NE(of(values), of(negative_zero));
}

TEST(Hash, AddingInPiecesIsAddingAtOnce) {
  Hash pieces;
  pieces.add("foo");
  pieces.add("bar");
  EXPECT_EQ(pieces.text(), fnv("foobar"));
}

/// Reference values: the check value of CRC-32/ISO-HDLC, and that of the empty message.
TEST(Crc32, AgreesWithTheCheckValue) {
  EXPECT_EQ(crc32(bytes("123456789")), 0xCBF43926U);
  EXPECT_EQ(crc32({}), 0U);
  EXPECT_NE(crc32(bytes("123456788")), crc32(bytes("123456789")));
}

/// Long messages are folded register by register: any length, start and split give what a byte at a time
/// gives.
TEST(Crc32, IsThatOfItsParts) {
  std::vector<std::byte> message(5000);
  for (std::size_t i = 0; i < message.size(); ++i) message[i] = static_cast<std::byte>((i * i + 7 * i) % 251);
  const auto by_bytes = [](std::span<const std::byte> part) {
    std::uint32_t crc = 0;
    for (const std::byte& b : part) crc = crc32({&b, 1}, crc);
    return crc;
  };
  for (const std::size_t start : {0, 1, 13})
    for (const std::size_t size :
         {63, 64, 255, 256, 257, 319, 320, 1000, 1023, 1024, 1279, 1280, 4096, 4987}) {
      const auto part = std::span<const std::byte>(message).subspan(start, size);
      const std::uint32_t expected = by_bytes(part);
      EXPECT_EQ(crc32(part), expected) << start << ", " << size;
      EXPECT_EQ(crc32(part.subspan(size / 3), crc32(part.first(size / 3))), expected)
          << start << ", " << size;
    }
}

TEST(NearestName, FindsTypingErrorsOnly) {
  const std::vector<std::string> names = {"time_step", "end_time", "boundary", "u"};
  EXPECT_EQ(nearest_name("tiem_step", names), "time_step");
  EXPECT_EQ(nearest_name("boundry", names), "boundary");
  EXPECT_EQ(nearest_name("viscosity", names), "");
  EXPECT_EQ(nearest_name("anything", {}), "");
}

Result<int> half(int n) {
  if (n % 2 != 0) return config_error("{} is odd", n);
  return n / 2;
}

Result<int> quarter(int n) {
  DROGUE_TRY(half(n));
  return half(half(n).value());
}

TEST(Result, HoldsAValueOrPassesTheErrorOn) {
  EXPECT_EQ(quarter(12).value(), 3);
  ASSERT_FALSE(quarter(7).ok());
  EXPECT_EQ(quarter(7).error().message, "7 is odd");
  EXPECT_EQ(quarter(6).error().message, "3 is odd");
  EXPECT_EQ(exit_status(quarter(7).error()), 2);
  EXPECT_EQ(exit_status(numerical_error("x")), 3);
  EXPECT_TRUE(retryable_error("x").retryable);
  EXPECT_FALSE(numerical_error("x").retryable);
}

} // namespace
} // namespace drogue
