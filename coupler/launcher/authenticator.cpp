// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/launcher/authenticator.hpp"

#include <array>
#include <vector>

#include <spdlog/spdlog.h>

namespace drogue::launcher {
namespace {

constexpr std::size_t key_bytes = 32;
/// Frames of a question: version, number, domain, address, identity, mechanism, and the key.
enum : std::size_t {
  number_frame = 1,
  address_frame = 3,
  mechanism_frame = 5,
  key_frame = 6,
  frame_count = 7
};

std::string key_text(const zmq::message_t& key) {
  if (key.size() != key_bytes) return {};
  std::array<char, 41> text{};
  return zmq_z85_encode(text.data(), key.data<std::uint8_t>(), key_bytes) ? text.data() : "";
}

} // namespace

Result<void> Authenticator::open(zmq::context_t& context, std::map<std::string, std::string> allowed) {
  allowed_ = std::move(allowed);
  try {
    socket_ = zmq::socket_t(context, zmq::socket_type::rep);
    socket_.set(zmq::sockopt::linger, 0);
    socket_.bind("inproc://zeromq.zap.01");
  } catch (const zmq::error_t& e) {
    return internal_error("cannot authenticate connections: {}", e.what());
  }
  return {};
}

void Authenticator::answer_all() {
  while (true) {
    std::vector<zmq::message_t> question;
    do {
      zmq::message_t frame;
      if (!socket_.recv(frame, zmq::recv_flags::dontwait)) return;
      question.push_back(std::move(frame));
    } while (question.back().more());
    if (question.size() <= mechanism_frame) return;
    const bool curve =
        question.size() == frame_count && question[mechanism_frame].to_string_view() == "CURVE";
    const auto it = allowed_.find(curve ? key_text(question[key_frame]) : "");
    const bool is_allowed = it != allowed_.end();
    if (!is_allowed)
      spdlog::warn("a connection from {} was refused: its key is no participant's",
                   question[address_frame].to_string_view());
    for (const std::string& frame :
         {std::string("1.0"), question[number_frame].to_string(), std::string(is_allowed ? "200" : "400"),
          std::string(is_allowed ? "OK" : "this key is not allowed"),
          is_allowed ? it->second : std::string()})
      socket_.send(zmq::buffer(frame), zmq::send_flags::sndmore);
    socket_.send(zmq::message_t(), zmq::send_flags::none); // no metadata
  }
}

} // namespace drogue::launcher
