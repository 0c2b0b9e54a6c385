// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <string>

#include <zmq.hpp>

#include "common/base/result.hpp"

/// Keys of connections that leave the machine (CURVE, elliptic-curve encryption of ZeroMQ): each side has a
/// key pair and knows the other's public half. Keys are written as ZeroMQ's Z85 text, 40 characters.
namespace drogue::keys {

struct KeyPair {
  std::string public_half, secret_half;
};

[[nodiscard]] Result<KeyPair> make();

/// Writes FOLDER/NAME.key (both halves, readable by its owner alone) and FOLDER/NAME.pub. Errors
/// (ErrorKind::config): a file is there already, or cannot be written.
[[nodiscard]] Result<void> write(const std::filesystem::path& folder, const std::string& name,
                                 const KeyPair& pair);
/// Of a .key file. Errors (ErrorKind::config): no such file, or no such key in it, or others may read it.
[[nodiscard]] Result<KeyPair> read_pair(const std::filesystem::path& file);
/// Of a .pub or .key file.
[[nodiscard]] Result<std::string> read_public(const std::filesystem::path& file);

[[nodiscard]] bool is_key(const std::string& text);

/// Whether nobody on another machine can reach the endpoint: ipc, and TCP on a loopback address.
[[nodiscard]] bool stays_on_this_machine(const std::string& endpoint);

/// Makes a participant's socket speak to the coupler that holds the secret half of `coupler_key`.
void use(zmq::socket_t& socket, const KeyPair& own, const std::string& coupler_key);

} // namespace drogue::keys
