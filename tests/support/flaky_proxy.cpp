// SPDX-License-Identifier: GPL-3.0-or-later
// Stands between the coupler and a participant and spoils what they say to each other.
//
// usage: flaky_proxy FAULT REQUEST PROGRAM ARGUMENTS --connect ENDPOINT
//   FAULT    DUPLICATE_REQUEST DUPLICATE_ANSWER DELAY_REQUEST DELAY_ANSWER   of REQUEST: twice, 0.4 s late
//            GARBAGE_TO_COUPLER GARBAGE_TO_PARTICIPANT                        in place of the answer, the
//            request VERSION MAGIC                        Hello says that it speaks version 2; its first
//            frame says so
//   REQUEST  Hello Configure Initialize BeginStep Iterate Commit Checkpoint Shutdown; of those that come
//   again and
//            again it is the first in step 3, and the checkpoint of step 4
#include <csignal>
#include <cstdlib>
#include <string>
#include <thread>
#include <vector>

#include <sys/prctl.h>
#include <zmq.hpp>

#include "coupler/launcher/process.hpp"
#include "participant/cpp/protocol_state.hpp"
#include "participant/cpp/wire.hpp"

namespace {

using namespace drogue;
using Frames = std::vector<std::string>;
constexpr auto delay = std::chrono::milliseconds(400);

Frames receive(zmq::socket_t& socket) {
  Frames frames;
  zmq::message_t frame;
  do {
    if (!socket.recv(frame)) return frames;
    frames.push_back(frame.to_string());
  } while (frame.more());
  return frames;
}

void send(zmq::socket_t& socket, const Frames& frames) {
  for (std::size_t i = 0; i < frames.size(); ++i)
    socket.send(zmq::buffer(frames[i]),
                i + 1 < frames.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
}

class Proxy {
 public:
  Proxy(std::string fault, std::string request) : fault_(std::move(fault)), request_(std::move(request)) {}

  int run(const std::string& role, const std::string& coupler, std::vector<std::string> program) {
    std::string folder = (std::filesystem::temp_directory_path() / "drogue-XXXXXX").string();
    if (!mkdtemp(folder.data())) return 1;
    const std::string endpoint = "ipc://" + folder + "/proxy";
    to_participant_.bind(endpoint);
    to_coupler_.set(zmq::sockopt::routing_id, role);
    to_coupler_.connect(coupler);
    program.insert(program.end(), {"--connect", endpoint});
    auto process = launcher::Process::start({program, {}, ".", "participant.log"});
    if (!process) return 1;
    route_ = role;
    while (!process->poll()) forward();
    while (forward()) {
    }
    std::filesystem::remove_all(folder);
    to_coupler_.set(zmq::sockopt::linger, 1000);
    return process->poll()->signal != 0 ? 128 + process->poll()->signal : process->poll()->status;
  }

 private:
  /// Both ways, for a moment. @return whether anything came
  bool forward() {
    std::vector<zmq::pollitem_t> items{{to_coupler_.handle(), 0, ZMQ_POLLIN, 0},
                                       {to_participant_.handle(), 0, ZMQ_POLLIN, 0}};
    zmq::poll(items, std::chrono::milliseconds(20));
    if (items[0].revents != 0) request(receive(to_coupler_));
    if (items[1].revents != 0) answer(receive(to_participant_));
    return items[0].revents != 0 || items[1].revents != 0;
  }

  void request(Frames frames) {
    v1::Envelope e;
    e.ParseFromString(frames.at(1));
    spoiled_ = strikes(e);
    if (spoiled_ && fault_ == "DELAY_REQUEST") std::this_thread::sleep_for(delay);
    if (spoiled_ && fault_ == "GARBAGE_TO_PARTICIPANT") frames = {"GET / HTTP/1.1", "", "Host: nowhere"};
    frames.insert(frames.begin(), route_);
    send(to_participant_, frames);
    if (spoiled_ && fault_ == "DUPLICATE_REQUEST") send(to_participant_, frames);
  }

  void answer(Frames frames) {
    frames.erase(frames.begin());
    v1::Envelope e;
    e.ParseFromString(frames.at(1));
    const bool hello = e.has_hello() && request_ == "Hello";
    if (hello && fault_ == "VERSION") {
      e.mutable_hello()->set_min_version(2);
      e.mutable_hello()->set_max_version(2);
      frames[1] = e.SerializeAsString();
    }
    if (hello && fault_ == "MAGIC") frames[0][4] = 2;
    const bool now = hello || (spoiled_ && !e.has_beat());
    if (now && fault_ == "DELAY_ANSWER") std::this_thread::sleep_for(delay);
    if (now && fault_ == "GARBAGE_TO_COUPLER") frames = {"GET / HTTP/1.1", "", "Host: nowhere"};
    send(to_coupler_, frames);
    if (now && fault_ == "DUPLICATE_ANSWER") send(to_coupler_, frames);
    if (now) spoiled_ = false;
  }

  /// Once.
  bool strikes(const v1::Envelope& e) {
    if (struck_ || participant::name(e.body_case()) != request_) return false;
    const bool in_step = e.has_begin_step() || e.has_iterate() || e.has_commit();
    if ((in_step && e.step() < 3) || (e.has_checkpoint() && e.step() < 4)) return false;
    return struck_ = true;
  }

  std::string fault_, request_, route_;
  bool struck_ = false, spoiled_ = false;
  zmq::context_t context_;
  zmq::socket_t to_coupler_{context_, zmq::socket_type::dealer},
      to_participant_{context_, zmq::socket_type::router};
};

} // namespace

int main(int argc, char** argv) {
  const std::vector<std::string> a(argv + 1, argv + argc);
  const char* role = std::getenv("DROGUE_PARTICIPANT");
  if (a.size() < 5 || !role) return 2;
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  return Proxy(a[0], a[1]).run(role, a.back(), {a.begin() + 2, a.end() - 2});
}
