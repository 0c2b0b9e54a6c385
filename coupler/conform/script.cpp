// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/conform/script.hpp"

#include <algorithm>
#include <cmath>
#include <csignal>
#include <cstring>
#include <thread>

#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

namespace drogue::coupler::conform {
namespace {

using participant::ProtocolState;
using Body = v1::Envelope;

wire::Message message(int step = 0, int iteration = 0) {
  wire::Message m;
  m.envelope.set_step(static_cast<std::uint64_t>(step));
  m.envelope.set_iteration(static_cast<std::uint32_t>(iteration));
  m.envelope.set_attempt(1);
  return m;
}

template <class Arrays>
Result<void> same_arrays(const Arrays& expected, const Arrays& got) {
  for (const auto& [name, array] : expected) {
    const auto it = got.find(name);
    if (it == got.end()) return peer_error("array \"{}\" is missing", name);
    if (it->second.shape != array.shape)
      return peer_error("array \"{}\" has shape {{{}}} in place of {{{}}}", name,
                        fmt::join(it->second.shape, ", "), fmt::join(array.shape, ", "));
    for (std::size_t i = 0; i < array.values.size(); ++i)
      if (std::memcmp(&array.values[i], &it->second.values[i], sizeof array.values[i]) != 0)
        return peer_error("value {} of \"{}\" is {} in place of {}", i, name, it->second.values[i],
                          array.values[i]);
  }
  if (got.size() != expected.size())
    return peer_error("{} arrays in place of {}", got.size(), expected.size());
  return {};
}

} // namespace

wire::Message configure(const Trial& trial, const std::filesystem::path& folder, bool resume) {
  wire::Message m = message();
  v1::Configure& c = *m.envelope.mutable_configure();
  c.set_version(wire::version);
  c.set_directory(folder.string());
  c.set_time_step(trial.sizes.time_step);
  c.set_resume(resume);
  return m;
}
wire::Message initialize() {
  wire::Message m = message();
  m.envelope.mutable_initialize();
  return m;
}
wire::Message begin_step(const Trial& trial, int step, int attempt) {
  wire::Message m = message(step);
  m.envelope.set_attempt(static_cast<std::uint32_t>(attempt));
  m.envelope.mutable_begin_step()->set_time((step - 1) * trial.sizes.time_step);
  m.envelope.mutable_begin_step()->set_time_step(trial.sizes.time_step);
  return m;
}
wire::Message iterate(const Trial& trial, int step, int iteration) {
  wire::Message m = message(step, iteration);
  m.envelope.mutable_iterate();
  m.floats = inputs_for(trial.record.hello, trial.record.surface, trial.sizes, step, iteration);
  return m;
}
wire::Message commit(int step) {
  wire::Message m = message(step);
  m.envelope.mutable_commit()->set_write_output(true);
  return m;
}
wire::Message rollback(int step) {
  wire::Message m = message(step);
  m.envelope.mutable_rollback();
  return m;
}
wire::Message checkpoint(const std::filesystem::path& folder) {
  wire::Message m = message(1);
  m.envelope.mutable_checkpoint()->set_directory(folder.string());
  return m;
}
wire::Message restore(const std::filesystem::path& folder) {
  wire::Message m = message(1);
  m.envelope.mutable_restore()->set_directory(folder.string());
  return m;
}
wire::Message replace_mesh(const std::filesystem::path& file) {
  wire::Message m = message(1);
  m.envelope.mutable_replace_mesh()->set_file(file.string());
  m.envelope.mutable_replace_mesh()->set_mesh_hash("none");
  return m;
}
wire::Message shutdown() {
  wire::Message m = message();
  m.envelope.mutable_shutdown();
  return m;
}
wire::Message abort_run() {
  wire::Message m = message();
  m.envelope.mutable_abort()->set_reason("a check of Abort");
  return m;
}

Result<wire::Message> ask_for(Session& session, wire::Message request, v1::Envelope::BodyCase answer) {
  const auto asked = request.envelope.body_case();
  auto got = session.ask(std::move(request));
  if (!got || got->envelope.body_case() == answer) return got;
  return peer_error("{}: {} expected, got {}", participant::name(asked), participant::name(answer),
                    answer_text(*got));
}

Result<wire::Message> ask_for_error(Session& session, wire::Message request, v1::Error::Code code) {
  const auto asked = request.envelope.body_case();
  auto got = session.ask(std::move(request));
  if (!got) return got;
  const bool any = code == v1::Error::CODE_UNSPECIFIED;
  if (got->envelope.has_error() && (any || got->envelope.error().code() == code)) return got;
  return peer_error("{}: Error {} expected, got {}", participant::name(asked),
                    any ? "" : v1::Error::Code_Name(code), answer_text(*got));
}

Result<v1::Hello> hello(Session& session) {
  const auto first = session.receive(Seconds(session.deadline()));
  if (!first) return first.error();
  if (!first->envelope.has_hello()) return peer_error("Hello expected, got {}", answer_text(*first));
  return first->envelope.hello();
}

Result<void> go_to(Session& session, const Trial& trial, ProtocolState state) {
  if (const auto said = hello(session); !said) return said.error();
  if (state == ProtocolState::greeted) return {};
  if (const auto got = ask_for(session, configure(trial, session.folder()), Body::kDone); !got)
    return got.error();
  if (state == ProtocolState::configured) return {};
  if (const auto got = ask_for(session, initialize(), Body::kInitialized); !got) return got.error();
  if (state == ProtocolState::ready) return {};
  if (const auto got = ask_for(session, begin_step(trial, 1), Body::kDone); !got) return got.error();
  if (state == ProtocolState::in_step) return {};
  const auto got = ask_for(session, iterate(trial, 1, 1), Body::kIterated);
  return got ? same(trial.record.answers[0][0], *got) : Result<void>(got.error());
}

Result<void> same_iterates(Session& session, const Trial& trial, int step, int attempt) {
  if (const auto got = ask_for(session, begin_step(trial, step, attempt), Body::kDone); !got)
    return got.error();
  for (int i = 1; i <= iterations_of_a_step; ++i) {
    const auto got = ask_for(session, iterate(trial, step, i), Body::kIterated);
    if (!got) return got.error();
    const auto& expected =
        trial.record.answers[static_cast<std::size_t>(step - 1)][static_cast<std::size_t>(i - 1)];
    if (const auto equal = same(expected, *got); !equal)
      return peer_error("step {}, iteration {}: {}", step, i, equal.error().message);
  }
  return {};
}

Result<void> same_step(Session& session, const Trial& trial, int step) {
  DROGUE_TRY(same_iterates(session, trial, step));
  const auto got = ask_for(session, commit(step), Body::kDone);
  return got ? Result<void>() : got.error();
}

Result<void> same(const wire::Message& expected, const wire::Message& got) {
  const auto &a = expected.envelope, &b = got.envelope;
  if (a.body_case() != b.body_case())
    return peer_error("{} in place of {}", answer_text(got), answer_text(expected));
  DROGUE_TRY(same_arrays(expected.floats, got.floats));
  DROGUE_TRY(same_arrays(expected.indices, got.indices));
  const auto &i = a.iterated(), &j = b.iterated();
  if (i.inner_iterations() != j.inner_iterations() || i.inner_residual() != j.inner_residual() ||
      i.converged() != j.converged())
    return peer_error("another report of its own iteration: {} iterations to {} in place of {} to {}",
                      j.inner_iterations(), j.inner_residual(), i.inner_iterations(), i.inner_residual());
  if (a.initialized().mesh_hash() != b.initialized().mesh_hash() ||
      a.initialized().mesh_node_count() != b.initialized().mesh_node_count())
    return peer_error("another mesh");
  return {};
}

Result<Surface> surface_of(const wire::Message& initialized) {
  const auto points = initialized.floats.find("points");
  if (points == initialized.floats.end()) return peer_error("\"points\" is missing");
  const auto& shape = points->second.shape;
  if (shape.size() != 2 || shape[0] == 0 || shape[1] != 3)
    return peer_error("\"points\" has shape {{{}}}; it must be {{n, 3}} with n > 0", fmt::join(shape, ", "));
  Surface s{shape[0], initialized.envelope.initialized().mesh_node_count(), 1};
  for (const auto& [name, array] : initialized.floats) {
    if (array.shape != shape)
      return peer_error("\"{}\" has shape {{{}}}; it must be that of \"points\", {{{}}}", name,
                        fmt::join(array.shape, ", "), fmt::join(shape, ", "));
    if (const auto bad = wire::first_not_finite(array.values))
      return peer_error("\"{}\" is not finite at node {}", name, *bad / 3);
  }
  for (const auto& [name, array] : initialized.indices) {
    const std::uint64_t end = name == "mesh_nodes" ? s.mesh_nodes : s.nodes;
    for (const std::int64_t i : array.values)
      if (i < 0 || static_cast<std::uint64_t>(i) >= end)
        return peer_error("\"{}\" names node {} of {}", name, i, end);
  }
  double squares = 0;
  for (std::size_t c = 0; c < 3; ++c) {
    double low = points->second.values[c], high = low;
    for (std::size_t i = c; i < points->second.values.size(); i += 3) {
      low = std::min(low, points->second.values[i]);
      high = std::max(high, points->second.values[i]);
    }
    squares += (high - low) * (high - low);
  }
  if (squares > 0) s.size = std::sqrt(squares);
  return s;
}

void play(const Trial& trial, Report& report, const std::string& label,
          const std::vector<std::string_view>& promises, const std::function<Result<void>(Session&)>& body,
          int peer_deadline) {
  const auto asked_for = [&](std::string_view promise) {
    return std::find(trial.only.begin(), trial.only.end(), promise) != trial.only.end();
  };
  if (!trial.record.answers.empty() && !trial.only.empty() &&
      std::none_of(promises.begin(), promises.end(), asked_for))
    return;
  const std::string_view promise = promises.front();
  spdlog::debug("{} ({})", promise, label);
  auto session = Session::start(trial.subject, label, peer_deadline);
  if (!session) return report.fail(promise, session.error().message);
  const auto outcome = body(**session);
  if (outcome)
    report.pass(promise);
  else
    report.fail(promise, outcome.error().message);
  if (!(*session)->misnamed().empty()) report.fail("identity", (*session)->misnamed());
}

void check_orphans(const v1::Hello& hello, Report& report) {
  const auto left = [&] {
    return std::find_if(hello.pid().begin(), hello.pid().end(),
                        [](std::int64_t pid) { return kill(static_cast<pid_t>(pid), 0) == 0; });
  };
  for (int i = 0; i < 100 && left() != hello.pid().end(); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  if (left() == hello.pid().end())
    report.pass("orphans");
  else
    report.fail("orphans", fmt::format("process {} is still there", *left()));
}

} // namespace drogue::coupler::conform
