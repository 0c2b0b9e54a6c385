// SPDX-License-Identifier: GPL-3.0-or-later
#include "participant/cpp/wire.hpp"

#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include <fmt/ranges.h>

#include "common/base/hash.hpp"

namespace drogue::wire {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays travel in little-endian order");

constexpr char magic[5] = {'D', 'R', 'G', 'W', static_cast<char>(version)};
constexpr std::size_t max_frames = 64;
constexpr std::int64_t max_frame_bytes = std::int64_t{8} << 30;

template <class T>
zmq::message_t frame_of(const std::vector<T>& values) {
  return zmq::message_t(values.data(), values.size() * sizeof(T));
}

template <class Array>
void describe(v1::Envelope& envelope, const std::string& name, const Array& array,
              v1::ArrayHeader::Type type) {
  v1::ArrayHeader& header = *envelope.add_array();
  header.set_name(name);
  header.set_type(type);
  for (const std::uint64_t extent : array.shape) header.add_shape(extent);
  header.set_byte_length(array.values.size() * 8);
  header.set_crc32(crc32(std::as_bytes(std::span(array.values))));
}

/// Number of values a header promises, or nothing when it overflows.
std::optional<std::uint64_t> value_count(const v1::ArrayHeader& header) {
  std::uint64_t count = 1;
  for (const std::uint64_t extent : header.shape()) {
    if (extent != 0 && count > std::numeric_limits<std::uint64_t>::max() / 8 / extent) return std::nullopt;
    count *= extent;
  }
  return count;
}

Result<void> check(const v1::ArrayHeader& header, const zmq::message_t& frame) {
  const auto count = value_count(header);
  if (!count || *count * 8 != header.byte_length())
    return peer_error("array \"{}\": shape {{{}}} does not make {} bytes", header.name(),
                      fmt::join(header.shape(), ", "), header.byte_length());
  if (frame.size() != header.byte_length())
    return peer_error("array \"{}\": expected {} bytes, the frame has {}", header.name(),
                      header.byte_length(), frame.size());
  const std::uint32_t crc = crc32({static_cast<const std::byte*>(frame.data()), frame.size()});
  if (crc != header.crc32())
    return peer_error("array \"{}\": checksum {:08x} expected, the frame has {:08x}", header.name(),
                      header.crc32(), crc);
  return {};
}

template <class Array>
Array unpack(const v1::ArrayHeader& header, const zmq::message_t& frame) {
  Array array;
  array.shape.assign(header.shape().begin(), header.shape().end());
  array.values.resize(frame.size() / 8);
  if (!array.values.empty()) std::memcpy(array.values.data(), frame.data(), frame.size());
  return array;
}

Result<Message> decode(const std::vector<zmq::message_t>& frames, std::size_t first) {
  if (frames.size() < first + 2)
    return peer_error("a message of {} frames is too short: magic and envelope expected",
                      frames.size() - first);
  const zmq::message_t& head = frames[first];
  if (head.size() != sizeof(magic) || std::memcmp(head.data(), magic, 4) != 0)
    return peer_error("not a Drogue message: the first frame must be \"DRGW\" and the version");
  if (static_cast<const char*>(head.data())[4] != magic[4])
    return peer_error("the peer speaks protocol version {}, this side version {}",
                      static_cast<int>(static_cast<const char*>(head.data())[4]), version);
  Message message;
  const zmq::message_t& body = frames[first + 1];
  if (!message.envelope.ParseFromArray(body.data(), static_cast<int>(body.size())))
    return peer_error("the envelope cannot be parsed ({} bytes)", body.size());
  const auto arrays = static_cast<std::size_t>(message.envelope.array_size());
  if (frames.size() != first + 2 + arrays)
    return peer_error("the envelope announces {} arrays, {} frames follow", arrays,
                      frames.size() - first - 2);
  for (std::size_t i = 0; i < arrays; ++i) {
    const v1::ArrayHeader& header = message.envelope.array(static_cast<int>(i));
    const zmq::message_t& frame = frames[first + 2 + i];
    DROGUE_TRY(check(header, frame));
    if (header.type() == v1::ArrayHeader::FLOAT64)
      message.floats[header.name()] = unpack<participant::FloatArray>(header, frame);
    else if (header.type() == v1::ArrayHeader::INT64)
      message.indices[header.name()] = unpack<participant::IndexArray>(header, frame);
    else
      return peer_error("array \"{}\" has an unknown type ({})", header.name(),
                        static_cast<int>(header.type()));
  }
  return message;
}

} // namespace

void prepare(zmq::socket_t& socket) {
  socket.set(zmq::sockopt::linger, 0);
  socket.set(zmq::sockopt::maxmsgsize, max_frame_bytes);
  socket.set(zmq::sockopt::sndhwm, 1000);
  socket.set(zmq::sockopt::rcvhwm, 1000);
}

Result<void> send(zmq::socket_t& socket, const std::string& route, const Message& message,
                  std::chrono::milliseconds deadline) {
  v1::Envelope envelope = message.envelope;
  envelope.clear_array();
  std::vector<zmq::message_t> frames;
  if (!route.empty()) frames.emplace_back(route.data(), route.size());
  frames.emplace_back(magic, sizeof(magic));
  frames.emplace_back(); // the envelope, once it knows its arrays
  const std::size_t body = frames.size() - 1;
  for (const auto& [name, array] : message.floats) {
    describe(envelope, name, array, v1::ArrayHeader::FLOAT64);
    frames.push_back(frame_of(array.values));
  }
  for (const auto& [name, array] : message.indices) {
    describe(envelope, name, array, v1::ArrayHeader::INT64);
    frames.push_back(frame_of(array.values));
  }
  const std::string bytes = envelope.SerializeAsString();
  frames[body] = zmq::message_t(bytes.data(), bytes.size());

  try {
    socket.set(zmq::sockopt::sndtimeo, static_cast<int>(deadline.count()));
    for (std::size_t i = 0; i < frames.size(); ++i) {
      const auto flags = i + 1 < frames.size() ? zmq::send_flags::sndmore : zmq::send_flags::none;
      if (!socket.send(frames[i], flags))
        return peer_error("the peer took no message for {} ms", deadline.count());
    }
  } catch (const zmq::error_t& e) {
    return peer_error("cannot send: {}", e.what());
  }
  return {};
}

Result<std::optional<Received>> receive(zmq::socket_t& socket, bool routed) {
  std::vector<zmq::message_t> frames;
  try {
    do {
      zmq::message_t frame;
      const auto flags = frames.empty() ? zmq::recv_flags::dontwait : zmq::recv_flags::none;
      if (!socket.recv(frame, flags)) return std::optional<Received>{};
      if (frames.size() < max_frames + 3) frames.push_back(std::move(frame));
    } while (socket.get(zmq::sockopt::rcvmore) != 0);
  } catch (const zmq::error_t& e) {
    return peer_error("cannot receive: {}", e.what());
  }
  if (frames.size() > max_frames + 2) return peer_error("a message of more than {} frames", max_frames);
  Received received;
  if (routed) received.route = frames[0].to_string();
  auto message = decode(frames, routed ? 1 : 0);
  if (!message)
    return routed ? peer_error("from {}: {}", received.route, message.error().message) : message.error();
  received.message = std::move(*message);
  return std::optional<Received>(std::move(received));
}

std::optional<std::size_t> first_not_finite(const std::vector<double>& values) {
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i])) return i;
  return std::nullopt;
}

} // namespace drogue::wire
