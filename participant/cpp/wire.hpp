// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <zmq.hpp>

#include "common/base/result.hpp"
#include "drogue/v1/wire.pb.h"
#include "participant/cpp/participant.hpp"

/// Multipart messages (docs/protocol.md) to and from ZeroMQ sockets; used by participants and by the coupler.
namespace drogue::wire {

inline constexpr std::uint32_t version = 1;

/// An envelope and the arrays that travel behind it, by name. Envelope::array is filled by send().
struct Message {
  v1::Envelope envelope;
  std::map<std::string, participant::FloatArray> floats;
  std::map<std::string, participant::IndexArray> indices;
};

/// What travels: magic, envelope, and a frame for each array.
using Frames = std::vector<zmq::message_t>;

/// The frames of a message; large arrays are handed over, not copied.
[[nodiscard]] Frames encode(Message message);
/// The message in some frames. Verifies magic, version, sizes and checksums of every array before anything is
/// allocated for it. Errors (ErrorKind::peer): malformed, with what was expected and what came.
[[nodiscard]] Result<Message> decode(std::span<const zmq::message_t> frames);

/// Sends frames, which stay as they are and may be sent again; on a ROUTER socket `route` is the peer's
/// identity, on a DEALER it is empty. Errors (ErrorKind::peer): the peer is gone, or takes nothing for
/// `deadline`.
[[nodiscard]] Result<void> send(zmq::socket_t& socket, const std::string& route, Frames& frames,
                                std::chrono::milliseconds deadline);
[[nodiscard]] Result<void> send(zmq::socket_t& socket, const std::string& route, Message message,
                                std::chrono::milliseconds deadline);

/// Frames as they came.
struct Parcel {
  std::string route; ///< on a ROUTER socket: identity that the sender gave itself
  std::string user;  ///< whose key the connection has, as the socket's authenticator named it; empty without
  int connection = -1; ///< descriptor of the connection
  Frames frames;
};

/// Takes one waiting message as it is; nothing when none is there. Errors (ErrorKind::peer): the socket
/// fails.
/// @param routed the socket is a ROUTER
[[nodiscard]] Result<std::optional<Parcel>> take(zmq::socket_t& socket, bool routed);

struct Received {
  std::string route;
  Message message;
};

/// Takes and decodes one waiting message; nothing when none is there. Errors: as take() and decode().
[[nodiscard]] Result<std::optional<Received>> receive(zmq::socket_t& socket, bool routed);

/// Applies the limits that every Drogue socket has: message size, linger, high-water marks.
void prepare(zmq::socket_t& socket);

/// Index of the first value that is not finite, or nothing.
[[nodiscard]] std::optional<std::size_t> first_not_finite(const std::vector<double>& values);

} // namespace drogue::wire
