// SPDX-License-Identifier: GPL-3.0-or-later
#include "participant/cpp/wire.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include <fmt/ranges.h>
#include <sys/mman.h>

#include "common/base/hash.hpp"

namespace drogue::wire {
namespace {

static_assert(std::endian::native == std::endian::little, "arrays travel in little-endian order");

constexpr char magic[5] = {'D', 'R', 'G', 'W', static_cast<char>(version)};
constexpr std::size_t max_frames = 64;
constexpr std::int64_t max_frame_bytes = std::int64_t{8} << 30;
constexpr std::size_t max_envelope_bytes = std::size_t{1} << 20;
constexpr std::size_t max_name_length = 255;

constexpr std::uint64_t exponent = 0x7ff0000000000000; ///< bits of a float64

/// From this size on an array is handed over to ZeroMQ, below it is copied [bytes].
constexpr std::size_t smallest_handed_over = 65536;
/// Values that are checked and copied at once, while they are in the cache.
constexpr std::size_t chunk = 1024;
constexpr std::size_t large_page = std::size_t{2} << 20;

template <class T>
zmq::message_t frame_of(std::vector<T> values) {
  const std::size_t size = values.size() * sizeof(T);
  if (size < smallest_handed_over) return zmq::message_t(values.data(), size);
  auto* const owned = new std::vector<T>(std::move(values)); // until ZeroMQ has sent it
  return zmq::message_t(
      owned->data(), size, [](void*, void* vector) { delete static_cast<std::vector<T>*>(vector); }, owned);
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

Result<void> check_size(const v1::ArrayHeader& header, const zmq::message_t& frame) {
  const auto count = value_count(header);
  if (!count || *count * 8 != header.byte_length())
    return peer_error("array \"{}\": shape {{{}}} does not make {} bytes", header.name(),
                      fmt::join(header.shape(), ", "), header.byte_length());
  if (frame.size() != header.byte_length())
    return peer_error("array \"{}\": expected {} bytes, the frame has {}", header.name(),
                      header.byte_length(), frame.size());
  return {};
}

/// Memory for many values in large pages, where the system has them: a page fault for every 4 KB would cost
/// more than to receive the values. Only advice: a failure changes nothing.
template <class T>
void reserve(std::vector<T>& values, std::size_t count) {
  values.reserve(count);
  const auto begin =
      (reinterpret_cast<std::uintptr_t>(values.data()) + large_page - 1) / large_page * large_page;
  const auto end =
      (reinterpret_cast<std::uintptr_t>(values.data()) + count * sizeof(T)) / large_page * large_page;
  if (begin < end) madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
}

/// The values of a frame of the right size, and their checksum. Piece by piece, so that they are copied while
/// they are in the cache.
template <class T>
std::uint32_t copy(const zmq::message_t& frame, std::vector<T>& values) {
  const std::size_t count = frame.size() / sizeof(T);
  const auto* const bytes = static_cast<const std::byte*>(frame.data());
  const bool aligned = reinterpret_cast<std::uintptr_t>(bytes) % alignof(T) == 0;
  reserve(values, count);
  std::array<T, chunk> part;
  std::uint32_t crc = 0;
  for (std::size_t begin = 0; begin < count; begin += chunk) {
    const std::size_t n = std::min(count - begin, chunk);
    const T* next = reinterpret_cast<const T*>(bytes) + begin;
    if (!aligned)
      next = static_cast<const T*>(std::memcpy(part.data(), bytes + begin * sizeof(T), n * sizeof(T)));
    crc = crc32(std::as_bytes(std::span(next, n)), crc);
    values.insert(values.end(), next, next + n);
  }
  return crc;
}

template <class Array>
Result<Array> unpack(const v1::ArrayHeader& header, const zmq::message_t& frame) {
  DROGUE_TRY(check_size(header, frame));
  Array array;
  array.shape.assign(header.shape().begin(), header.shape().end());
  if (const std::uint32_t crc = copy(frame, array.values); crc != header.crc32())
    return peer_error("array \"{}\": checksum {:08x} expected, the frame has {:08x}", header.name(),
                      header.crc32(), crc);
  return array;
}

template <class Array>
Result<void> add(std::map<std::string, Array>& arrays, const v1::ArrayHeader& header,
                 const zmq::message_t& frame) {
  auto array = unpack<Array>(header, frame);
  if (!array) return array.error();
  if (!arrays.emplace(header.name(), std::move(*array)).second)
    return peer_error("array \"{}\" comes twice", header.name());
  return {};
}

Result<void> check_head(const zmq::message_t& head) {
  if (head.size() != sizeof(magic) || std::memcmp(head.data(), magic, 4) != 0)
    return peer_error("not a Drogue message: the first frame must be \"DRGW\" and the version");
  if (static_cast<const char*>(head.data())[4] != magic[4])
    return peer_error("the peer speaks protocol version {}, this side version {}",
                      static_cast<int>(static_cast<const char*>(head.data())[4]), version);
  return {};
}

} // namespace

Result<Message> decode(std::span<const zmq::message_t> frames) {
  if (frames.size() > max_frames + 2) return peer_error("a message of more than {} arrays", max_frames);
  if (frames.size() < 2)
    return peer_error("a message of {} frames is too short: magic and envelope expected", frames.size());
  DROGUE_TRY(check_head(frames[0]));
  Message message;
  const zmq::message_t& body = frames[1];
  if (body.size() > max_envelope_bytes ||
      !message.envelope.ParseFromArray(body.data(), static_cast<int>(body.size())))
    return peer_error("the envelope cannot be parsed ({} bytes)", body.size());
  const auto arrays = static_cast<std::size_t>(message.envelope.array_size());
  if (frames.size() != 2 + arrays)
    return peer_error("the envelope announces {} arrays, {} frames follow", arrays, frames.size() - 2);
  for (std::size_t i = 0; i < arrays; ++i) {
    const v1::ArrayHeader& header = message.envelope.array(static_cast<int>(i));
    const zmq::message_t& frame = frames[2 + i];
    if (header.name().size() > max_name_length)
      return peer_error("the name of array {} has more than {} characters", i + 1, max_name_length);
    if (header.type() == v1::ArrayHeader::FLOAT64)
      DROGUE_TRY(add(message.floats, header, frame));
    else if (header.type() == v1::ArrayHeader::INT64)
      DROGUE_TRY(add(message.indices, header, frame));
    else
      return peer_error("array \"{}\" has an unknown type ({})", header.name(),
                        static_cast<int>(header.type()));
  }
  return message;
}

void prepare(zmq::socket_t& socket) {
  socket.set(zmq::sockopt::linger, 0);
  socket.set(zmq::sockopt::maxmsgsize, max_frame_bytes);
  socket.set(zmq::sockopt::sndhwm, 1000);
  socket.set(zmq::sockopt::rcvhwm, 1000);
}

Frames encode(Message message) {
  v1::Envelope& envelope = message.envelope;
  envelope.clear_array();
  Frames frames;
  frames.emplace_back(magic, sizeof(magic));
  frames.emplace_back(); // the envelope, once it knows its arrays
  for (auto& [name, array] : message.floats) {
    describe(envelope, name, array, v1::ArrayHeader::FLOAT64);
    frames.push_back(frame_of(std::move(array.values)));
  }
  for (auto& [name, array] : message.indices) {
    describe(envelope, name, array, v1::ArrayHeader::INT64);
    frames.push_back(frame_of(std::move(array.values)));
  }
  const std::string bytes = envelope.SerializeAsString();
  frames[1] = zmq::message_t(bytes.data(), bytes.size());
  return frames;
}

Result<void> send(zmq::socket_t& socket, const std::string& route, Frames& frames,
                  std::chrono::milliseconds deadline) {
  try {
    socket.set(zmq::sockopt::sndtimeo, static_cast<int>(deadline.count()));
    if (!route.empty() && !socket.send(zmq::buffer(route), zmq::send_flags::sndmore))
      return peer_error("the peer took no message for {} ms", deadline.count());
    for (std::size_t i = 0; i < frames.size(); ++i) {
      zmq::message_t shared; // the content is shared, not copied
      shared.copy(frames[i]);
      const auto flags = i + 1 < frames.size() ? zmq::send_flags::sndmore : zmq::send_flags::none;
      if (!socket.send(shared, flags))
        return peer_error("the peer took no message for {} ms", deadline.count());
    }
  } catch (const zmq::error_t& e) {
    return peer_error("cannot send: {}", e.what());
  }
  return {};
}

Result<void> send(zmq::socket_t& socket, const std::string& route, Message message,
                  std::chrono::milliseconds deadline) {
  Frames frames = encode(std::move(message));
  return send(socket, route, frames, deadline);
}

Result<std::optional<Parcel>> take(zmq::socket_t& socket, bool routed) {
  Parcel parcel;
  Frames& frames = parcel.frames;
  try {
    do {
      zmq::message_t frame;
      const auto flags = frames.empty() ? zmq::recv_flags::dontwait : zmq::recv_flags::none;
      if (!socket.recv(frame, flags)) return std::optional<Parcel>{};
      if (frames.size() < max_frames + 4) frames.push_back(std::move(frame));
    } while (socket.get(zmq::sockopt::rcvmore) != 0);
    if (const char* user = zmq_msg_gets(frames.back().handle(), "User-Id")) parcel.user = user;
    parcel.connection = zmq_msg_get(frames.back().handle(), ZMQ_SRCFD);
  } catch (const zmq::error_t& e) {
    return peer_error("cannot receive: {}", e.what());
  }
  if (routed) {
    parcel.route = frames[0].to_string();
    frames.erase(frames.begin());
  }
  return std::optional<Parcel>(std::move(parcel));
}

Result<std::optional<Received>> receive(zmq::socket_t& socket, bool routed) {
  auto parcel = take(socket, routed);
  if (!parcel) return parcel.error();
  if (!*parcel) return std::optional<Received>{};
  auto message = decode((**parcel).frames);
  if (!message)
    return routed ? peer_error("from {}: {}", (**parcel).route, message.error().message) : message.error();
  return std::optional<Received>({std::move((**parcel).route), std::move(*message)});
}

std::optional<std::size_t> first_not_finite(const std::vector<double>& values) {
  const std::size_t size = values.size();
  for (std::size_t begin = 0; begin < size; begin += chunk) {
    const std::size_t end = std::min(begin + chunk, size);
    std::uint64_t bad = 0; // all bits of the exponent are set: infinity or NaN
    for (std::size_t i = begin; i < end; ++i)
      bad |= ((std::bit_cast<std::uint64_t>(values[i]) & exponent) + (exponent & -exponent)) >> 63U;
    if (bad == 0) continue;
    for (std::size_t i = begin; i < end; ++i)
      if (!std::isfinite(values[i])) return i;
  }
  return std::nullopt;
}

} // namespace drogue::wire
