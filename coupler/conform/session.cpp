// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/conform/session.hpp"

#include <cstdlib>

#include <fmt/format.h>

#include "coupler/participant_command.hpp"
#include "participant/cpp/protocol_state.hpp"

namespace drogue::coupler::conform {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr auto send_deadline = std::chrono::seconds(10);
/// After the process has ended, how long its last message may still be under way.
constexpr auto last_message_grace = milliseconds(200);
/// After its connection is gone, how long its process may take to end.
constexpr auto death_notice = milliseconds(1000);

milliseconds whole(Seconds s) {
  return std::chrono::duration_cast<milliseconds>(s);
}

std::string last_words(const fs::path& log) {
  const auto lines = launcher::last_lines(log, 1);
  return lines.empty() ? "" : fmt::format("; its last line: {}", lines[0]);
}

} // namespace

std::string answer_text(const wire::Message& answer) {
  const v1::Envelope& e = answer.envelope;
  if (!e.has_error()) return std::string(participant::name(e.body_case()));
  return fmt::format("Error {} ({})", v1::Error::Code_Name(e.error().code()), e.error().message());
}

Result<std::unique_ptr<Session>> Session::start(const Subject& subject, const std::string& label,
                                                int peer_deadline) {
  std::unique_ptr<Session> session(new Session(subject, subject.folder / label));
  DROGUE_TRY(session->open(peer_deadline));
  return session;
}

Result<void> Session::open(int peer_deadline) {
  std::error_code failure;
  fs::create_directories(folder_, failure);
  if (failure) return config_error("cannot make the folder {}: {}", folder_.string(), failure.message());
  std::string folder = (fs::temp_directory_path() / "drogue-XXXXXX").string();
  if (!mkdtemp(folder.data())) return internal_error("cannot make a folder for the socket in {}", folder);
  socket_folder_ = folder;
  const std::string endpoint = fmt::format("ipc://{}/coupler", folder);
  try {
    router_ = zmq::socket_t(context_, zmq::socket_type::router);
    wire::prepare(router_);
    router_.set(zmq::sockopt::router_mandatory, true);
    router_.bind(endpoint);
  } catch (const zmq::error_t& e) {
    return internal_error("cannot listen at {}: {}", endpoint, e.what());
  }
  run_id_ = "conform-" + folder_.filename().string();
  ParticipantSettings settings;
  settings.name = subject_.role;
  std::vector<std::string> environment = participant_environment(settings);
  environment.push_back("DROGUE_RUN_ID=" + run_id_);
  environment.push_back(fmt::format("DROGUE_PEER_DEADLINE={}", peer_deadline));
  environment.emplace_back("OMPI_MCA_ess_singleton_isolated=1");
  std::vector<std::string> arguments = subject_.command;
  arguments.insert(arguments.end(), {"--connect", endpoint});
  auto process = launcher::Process::start({arguments, environment, fs::current_path(), folder_ / "log.txt"});
  if (!process) return process.error();
  process_ = std::move(*process);
  return {};
}

Session::~Session() {
  process_.reset(); // kills what is left
  disappear();
  std::error_code ignored;
  if (!socket_folder_.empty()) fs::remove_all(socket_folder_, ignored);
}

void Session::disappear() {
  router_.close();
}

Result<std::uint64_t> Session::send(wire::Message request) {
  v1::Envelope& e = request.envelope;
  if (e.run_id().empty()) e.set_run_id(run_id_);
  e.set_participant(subject_.role);
  e.set_request_id(++last_request_);
  last_sent_ = std::move(request);
  DROGUE_TRY(repeat());
  return last_request_;
}

Result<void> Session::repeat() {
  const auto sent = wire::send(router_, subject_.role, last_sent_, send_deadline);
  if (sent) return {};
  return peer_error("{} could not be sent: {}", participant::name(last_sent_.envelope.body_case()),
                    sent.error().message);
}

Result<void> Session::send_frames(const std::vector<std::string>& frames) {
  raw_ = true;
  try {
    router_.send(zmq::buffer(subject_.role), zmq::send_flags::sndmore);
    for (std::size_t i = 0; i < frames.size(); ++i)
      router_.send(zmq::buffer(frames[i]),
                   i + 1 < frames.size() ? zmq::send_flags::sndmore : zmq::send_flags::none);
  } catch (const zmq::error_t& e) {
    return peer_error("cannot send: {}", e.what());
  }
  return {};
}

void Session::check_identity(const wire::Message& message) {
  const v1::Envelope& e = message.envelope;
  if (!misnamed_.empty() || raw_) return;
  const std::string what(participant::name(e.body_case()));
  if (e.run_id() != run_id_)
    misnamed_ = fmt::format("{} carries run \"{}\" in place of \"{}\"", what, e.run_id(), run_id_);
  else if (e.participant() != subject_.role)
    misnamed_ = fmt::format("{} carries participant \"{}\" in place of \"{}\" (DROGUE_PARTICIPANT)", what,
                            e.participant(), subject_.role);
  else if ((e.has_hello() || e.has_beat()) && e.request_id() != 0)
    misnamed_ = fmt::format("{} carries request {} in place of 0", what, e.request_id());
  else if (!e.has_hello() && !e.has_beat() && e.request_id() != last_request_)
    misnamed_ = fmt::format("{} carries request {} in place of {}", what, e.request_id(), last_request_);
}

Result<wire::Message> Session::receive(Seconds deadline) {
  auto end = Clock::now() + whole(deadline);
  bool dying = false;
  while (true) {
    auto received = wire::receive(router_, true);
    if (!received) return received.error();
    if (*received) {
      wire::Message message = std::move((**received).message);
      check_identity(message);
      if (message.envelope.has_hello()) greeting_ = message.envelope.hello();
      if ((**received).route != subject_.role && misnamed_.empty())
        misnamed_ = fmt::format("its routing id is not \"{}\"", subject_.role);
      if (!message.envelope.has_beat()) return message;
      ++beats_;
      continue;
    }
    if (!dying && process_->poll()) {
      dying = true;
      end = Clock::now() + last_message_grace;
    }
    if (Clock::now() >= end) break;
    zmq::pollitem_t item{router_.handle(), 0, ZMQ_POLLIN, 0};
    zmq::poll(&item, 1, milliseconds(10));
  }
  if (dying) return peer_error("the process {}{}", process_->poll()->text(), last_words(folder_ / "log.txt"));
  return peer_error("nothing came for {:g} s{}", deadline.count(), last_words(folder_ / "log.txt"));
}

Result<wire::Message> Session::ask(wire::Message request) {
  const auto start = Clock::now();
  const int beats_before = beats_;
  if (const auto sent = send(std::move(request)); !sent) {
    const auto& exit = process_->wait(death_notice);
    return exit ? peer_error("{}: the process {}{}", participant::name(last_sent_.envelope.body_case()),
                             exit->text(), last_words(folder_ / "log.txt"))
                : sent.error();
  }
  auto answer = receive(Seconds(subject_.deadline));
  const double took = Seconds(Clock::now() - start).count();
  if (took > longest_work_) {
    longest_work_ = took;
    beats_then_ = beats_ - beats_before;
  }
  if (!answer)
    return peer_error("{}: {}", participant::name(last_sent_.envelope.body_case()), answer.error().message);
  return answer;
}

Result<launcher::Exit> Session::end(Seconds deadline) {
  const auto& exit = process_->wait(whole(deadline));
  if (!exit) return peer_error("it did not end within {:g} s", deadline.count());
  return *exit;
}

} // namespace drogue::coupler::conform
