// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
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

/// Sends `message`; on a ROUTER socket `route` is the peer's identity, on a DEALER it is empty.
/// Errors (ErrorKind::peer): the peer is gone, or takes nothing for `deadline`.
[[nodiscard]] Result<void> send(zmq::socket_t& socket, const std::string& route, const Message& message,
                                std::chrono::milliseconds deadline);

struct Received {
  std::string route;
  Message message;
};

/// Takes one waiting message; nothing when none is there. Verifies magic, version, sizes and checksums of
/// every array. Errors (ErrorKind::peer): a malformed message, with what was expected and what came.
/// @param routed the socket is a ROUTER
[[nodiscard]] Result<std::optional<Received>> receive(zmq::socket_t& socket, bool routed);

/// Applies the limits that every Drogue socket has: message size, linger, high-water marks.
void prepare(zmq::socket_t& socket);

/// Index of the first value that is not finite, or nothing.
[[nodiscard]] std::optional<std::size_t> first_not_finite(const std::vector<double>& values);

} // namespace drogue::wire
