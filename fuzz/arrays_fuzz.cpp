// SPDX-License-Identifier: GPL-3.0-or-later
// Arrays behind a well-formed envelope: shapes, lengths, types and names of all kinds, with the right
// checksum more often than not, so that what lies behind the checks is reached. What is taken holds as many
// values as its shape says.
#include <cstdlib>

#include <fuzzer/FuzzedDataProvider.h>

#include "common/base/hash.hpp"
#include "participant/cpp/wire.hpp"

namespace {

template <class Arrays>
void expect_filled(const Arrays& arrays) {
  for (const auto& [name, array] : arrays) {
    std::uint64_t count = 1;
    for (const std::uint64_t extent : array.shape) count *= extent;
    if (count != array.values.size()) std::abort();
  }
}

} // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace drogue;
  FuzzedDataProvider input(data, size);
  wire::Frames frames;
  frames.emplace_back("DRGW\x01", 5);
  frames.emplace_back();
  v1::Envelope envelope;
  envelope.mutable_iterate();
  const int arrays = input.ConsumeIntegralInRange(0, 6);
  for (int i = 0; i < arrays; ++i) {
    v1::ArrayHeader& header = *envelope.add_array();
    header.set_name(input.ConsumeRandomLengthString(300));
    header.set_type(static_cast<v1::ArrayHeader::Type>(input.ConsumeIntegralInRange(0, 3)));
    const int extents = input.ConsumeIntegralInRange(0, 4);
    std::uint64_t count = 1;
    for (int k = 0; k < extents; ++k) {
      header.add_shape(input.ConsumeBool() ? input.ConsumeIntegralInRange<std::uint64_t>(0, 8)
                                           : input.ConsumeIntegral<std::uint64_t>());
      count *= header.shape(k);
    }
    const bool fits = count < 1000 && input.ConsumeProbability<float>() < 0.8F;
    auto bytes = input.ConsumeBytes<std::uint8_t>(fits ? static_cast<std::size_t>(8 * count)
                                                       : input.ConsumeIntegralInRange<std::size_t>(0, 100));
    if (fits) bytes.resize(static_cast<std::size_t>(8 * count));
    header.set_byte_length(input.ConsumeBool() ? bytes.size() : 8 * count);
    header.set_crc32(input.ConsumeProbability<float>() < 0.9F ? crc32(std::as_bytes(std::span(bytes)))
                                                              : input.ConsumeIntegral<std::uint32_t>());
    frames.emplace_back(bytes.data(), bytes.size());
  }
  const std::string body = envelope.SerializeAsString();
  frames[1] = zmq::message_t(body.data(), body.size());
  const auto message = wire::decode(frames);
  if (!message) return 0;
  expect_filled(message->floats);
  expect_filled(message->indices);
  for (const auto& [name, array] : message->floats) (void)wire::first_not_finite(array.values);
  return 0;
}
