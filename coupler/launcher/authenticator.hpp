// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <map>
#include <string>

#include <zmq.hpp>

#include "common/base/result.hpp"

namespace drogue::launcher {

/// Decides whose CURVE keys may connect (ZeroMQ's authentication protocol, RFC 27): those of the list, each
/// as the participant it is listed for, which wire::Parcel::user then names.
class Authenticator {
 public:
  /// @param allowed participant by public key
  [[nodiscard]] Result<void> open(zmq::context_t& context, std::map<std::string, std::string> allowed);
  /// The socket on which ZeroMQ asks.
  [[nodiscard]] zmq::socket_t& socket() { return socket_; }
  /// Answers every question that waits.
  void answer_all();

 private:
  zmq::socket_t socket_;
  std::map<std::string, std::string> allowed_;
};

} // namespace drogue::launcher
