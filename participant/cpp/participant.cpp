// SPDX-License-Identifier: GPL-3.0-or-later
#include "participant/cpp/participant.hpp"

#include <charconv>
#include <cstdlib>
#include <cstring>
#include <optional>

#include <fmt/ranges.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "participant/cpp/protocol_state.hpp"
#include "participant/cpp/transport.hpp"
#include "participant/cpp/wire.hpp"

namespace drogue::participant {
namespace {

using Body = v1::Envelope;

std::string environment(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

/// An answer of kind Error with its code.
struct Refusal {
  v1::Error::Code code;
  std::string message;
  bool retryable = false;
};
using Verdict = std::optional<Refusal>;

v1::Error::Code code_of(const Error& error) {
  switch (error.kind) {
  case ErrorKind::config:
    return v1::Error::CONFIGURATION;
  case ErrorKind::numerical:
    return v1::Error::NUMERICAL;
  case ErrorKind::internal:
  case ErrorKind::peer:
  case ErrorKind::interrupted:
    return v1::Error::INTERNAL;
  }
  return v1::Error::INTERNAL;
}

/// The exit status that goes with a fatal refusal.
ErrorKind kind_of(v1::Error::Code code) {
  if (code == v1::Error::CONFIGURATION || code == v1::Error::UNSUPPORTED) return ErrorKind::config;
  return code == v1::Error::NUMERICAL ? ErrorKind::numerical : ErrorKind::internal;
}

Verdict verdict(const Result<void>& result) {
  if (result) return std::nullopt;
  return Refusal{code_of(result.error()), result.error().message, result.error().retryable};
}

template <class Array, class Values>
void put(std::map<std::string, Array>& arrays, const char* name, Values values, std::uint64_t columns) {
  if (values.empty()) return;
  std::vector<std::uint64_t> shape{values.size() / columns};
  if (columns > 1) shape.push_back(columns);
  arrays[name] = Array{std::move(shape), std::move(values)};
}

/// Serves one solver: checks every request against the protocol's table and the field contract, calls the
/// solver, and sends the answer.
class Server {
 public:
  Server(Solver& solver, Transport& transport, std::string run_id)
      : solver_(solver), transport_(transport), run_id_(std::move(run_id)), description_(solver.describe()) {}

  Result<void> run(std::chrono::seconds deadline) {
    say_hello();
    while (state_ != ProtocolState::finished && state_ != ProtocolState::failed) {
      auto request = transport_.next_request(deadline);
      if (!request) return request.error();
      answer(*request);
    }
    if (failure_) return *failure_;
    return {};
  }

 private:
  void say_hello() {
    wire::Message message;
    v1::Hello& hello = *message.envelope.mutable_hello();
    hello.set_min_version(wire::version);
    hello.set_max_version(wire::version);
    hello.set_software(description_.software);
    if (description_.pids.empty()) description_.pids.push_back(getpid());
    for (const std::int64_t pid : description_.pids) hello.add_pid(pid);
    hello.set_can_rollback(description_.can_rollback);
    hello.set_can_checkpoint(description_.can_checkpoint);
    hello.set_variable_step(description_.variable_step);
    hello.set_can_replace_mesh(description_.can_replace_mesh);
    for (const auto& f : description_.inputs) *hello.add_input() = f;
    for (const auto& f : description_.outputs) *hello.add_output() = f;
    transport_.post(std::move(message));
    state_ = ProtocolState::greeted;
  }

  void answer(const wire::Message& request) {
    const v1::Envelope& in = request.envelope;
    wire::Message reply;
    v1::Envelope& out = reply.envelope;
    out.set_request_id(in.request_id());
    out.set_step(in.step());
    out.set_iteration(in.iteration());
    out.set_attempt(in.attempt());

    Verdict refusal = admissible(in);
    const bool refused = refusal.has_value();
    if (!refused) refusal = perform(request, reply);
    if (refusal) {
      v1::Error& error = *out.mutable_error();
      error.set_code(refusal->code);
      error.set_message(refusal->message);
      error.set_retryable(refusal->retryable);
      reply.floats.clear();
      // A request that does not fit, or a step too large, leaves the participant as it was; the rest is
      // fatal.
      if (!refused && !refusal->retryable && refusal->code != v1::Error::BAD_MESSAGE &&
          refusal->code != v1::Error::NOT_FINITE)
        fail({kind_of(refusal->code), refusal->message});
    } else {
      state_ = *next_state(state_, in.body_case());
      if (out.body_case() == Body::BODY_NOT_SET) out.mutable_done();
    }
    transport_.post(std::move(reply));
  }

  [[nodiscard]] Verdict admissible(const v1::Envelope& in) const {
    if (in.run_id() != run_id_)
      return Refusal{v1::Error::BAD_MESSAGE,
                     fmt::format("run \"{}\" expected, got \"{}\"", run_id_, in.run_id())};
    if (!next_state(state_, in.body_case()))
      return Refusal{v1::Error::WRONG_STATE,
                     fmt::format("{} is not allowed in state {}", name(in.body_case()), name(state_))};
    return std::nullopt;
  }

  Verdict perform(const wire::Message& request, wire::Message& reply) {
    const v1::Envelope& in = request.envelope;
    switch (in.body_case()) {
    case Body::kConfigure:
      return configure(in.configure());
    case Body::kInitialize:
      return initialize(reply);
    case Body::kBeginStep:
      if (!description_.variable_step && time_step_ != 0 && in.begin_step().time_step() != time_step_)
        return Refusal{v1::Error::UNSUPPORTED, fmt::format("the step is fixed at {}, asked for {}",
                                                           time_step_, in.begin_step().time_step())};
      return verdict(
          solver_.begin_step({in.step(), in.attempt(), in.begin_step().time(), in.begin_step().time_step()}));
    case Body::kIterate:
      return iterate(request, reply);
    case Body::kCommit:
      return commit(in.commit(), reply);
    case Body::kReplaceMesh:
      return replace_mesh(in.replace_mesh(), reply);
    case Body::kRollback:
      return rollback();
    case Body::kCheckpoint:
      return checkpoint(in.checkpoint().directory(), true);
    case Body::kRestore:
      return checkpoint(in.restore().directory(), false);
    case Body::kAbort:
      fail({ErrorKind::peer, "the coupler aborted the run: " + in.abort().reason()});
      return std::nullopt;
    case Body::kShutdown:
      return std::nullopt;
    default:
      return Refusal{v1::Error::WRONG_STATE, "not a request"};
    }
  }

  Verdict configure(const v1::Configure& request) {
    if (request.version() != wire::version)
      return Refusal{v1::Error::UNSUPPORTED,
                     fmt::format("protocol version {} expected, got {}", wire::version, request.version())};
    time_step_ = request.time_step();
    return verdict(solver_.configure(
        {request.directory(), request.start_time(), request.time_step(), request.resume()}));
  }

  Verdict initialize(wire::Message& reply) {
    auto mesh = solver_.initialize();
    if (!mesh) return verdict(mesh.error());
    v1::Initialized& initialized = *reply.envelope.mutable_initialized();
    initialized.set_mesh_node_count(mesh->mesh_node_count);
    initialized.set_mesh_hash(mesh->mesh_hash);
    interface_nodes_ = mesh->points.size() / 3;
    mesh_nodes_ = mesh->mesh_node_count;
    put(reply.floats, "points", std::move(mesh->points), 3);
    put(reply.floats, "reference", std::move(mesh->reference), 3);
    put(reply.floats, "material", std::move(mesh->material), 3);
    put(reply.floats, "velocity", std::move(mesh->velocity), 3);
    for (const ElementArray& array : element_arrays)
      put(reply.indices, array.name, std::move((*mesh).*array.elements), array.nodes);
    put(reply.indices, "mesh_nodes", std::move(mesh->mesh_nodes), 1);
    return std::nullopt;
  }

  Verdict iterate(const wire::Message& request, wire::Message& reply) {
    if (Verdict bad = check_fields(description_.inputs, request.floats, "input")) return bad;
    const auto report = solver_.iterate(request.floats, reply.floats);
    if (!report) return verdict(report.error());
    if (Verdict bad = check_fields(description_.outputs, reply.floats, "output"))
      return Refusal{v1::Error::NUMERICAL, bad->message, bad->code == v1::Error::NOT_FINITE};
    v1::Iterated& iterated = *reply.envelope.mutable_iterated();
    iterated.set_inner_iterations(report->inner_iterations);
    iterated.set_inner_residual(report->inner_residual);
    iterated.set_converged(report->converged);
    iterated.set_fixed_iterations(report->fixed_iterations);
    return std::nullopt;
  }

  Verdict commit(const v1::Commit& request, wire::Message& reply) {
    if (Verdict refusal = verdict(solver_.commit(request.write_output()))) return refusal;
    v1::Done& done = *reply.envelope.mutable_done();
    if (const auto mesh = solver_.new_mesh()) {
      done.mutable_new_mesh()->set_file(mesh->file.string());
      done.mutable_new_mesh()->set_mesh_hash(mesh->mesh_hash);
      done.mutable_new_mesh()->set_reason(mesh->reason);
    }
    return std::nullopt;
  }

  Verdict replace_mesh(const v1::ReplaceMesh& request, wire::Message& reply) {
    if (!description_.can_replace_mesh)
      return Refusal{v1::Error::UNSUPPORTED, "this participant cannot replace its mesh"};
    auto mesh = solver_.replace_mesh({request.file(), request.mesh_hash(), ""}, request.restoring());
    if (!mesh) return verdict(mesh.error());
    if (mesh->mesh_nodes.size() != interface_nodes_)
      return Refusal{v1::Error::INTERNAL, fmt::format("the new mesh has {} interface nodes in place of {}",
                                                      mesh->mesh_nodes.size(), interface_nodes_)};
    mesh_nodes_ = mesh->mesh_node_count;
    v1::Replaced& replaced = *reply.envelope.mutable_replaced();
    replaced.set_mesh_node_count(mesh->mesh_node_count);
    replaced.set_mesh_hash(mesh->mesh_hash);
    replaced.set_mass_defect(mesh->mass_defect);
    replaced.set_momentum_defect(mesh->momentum_defect);
    replaced.set_energy_defect(mesh->energy_defect);
    put(reply.indices, "mesh_nodes", std::move(mesh->mesh_nodes), 1);
    return std::nullopt;
  }

  Verdict rollback() {
    if (!description_.can_rollback)
      return Refusal{v1::Error::UNSUPPORTED, "this participant cannot roll back"};
    return verdict(solver_.rollback());
  }

  Verdict checkpoint(const std::string& directory, bool save) {
    if (!description_.can_checkpoint)
      return Refusal{v1::Error::UNSUPPORTED, "this participant cannot checkpoint"};
    return verdict(save ? solver_.checkpoint(directory) : solver_.restore(directory));
  }

  [[nodiscard]] Verdict check_fields(const std::vector<v1::FieldContract>& contract, const Fields& fields,
                                     const char* what) const {
    for (const v1::FieldContract& entry : contract) {
      const auto it = fields.find(entry.name());
      if (it == fields.end()) {
        if (entry.optional()) continue;
        return Refusal{v1::Error::BAD_MESSAGE, fmt::format("{} \"{}\" is missing", what, entry.name())};
      }
      const std::vector<std::uint64_t> expected{node_count(entry.location()), entry.components()};
      if (it->second.shape != expected)
        return Refusal{v1::Error::BAD_MESSAGE,
                       fmt::format("{} \"{}\" has shape {{{}}}, expected {{{}}}", what, entry.name(),
                                   fmt::join(it->second.shape, ", "), fmt::join(expected, ", "))};
      if (const auto bad = wire::first_not_finite(it->second.values))
        return Refusal{v1::Error::NOT_FINITE,
                       fmt::format("{} \"{}\" is not finite at node {}, component {}", what, entry.name(),
                                   *bad / entry.components(), *bad % entry.components())};
    }
    return std::nullopt;
  }

  [[nodiscard]] std::uint64_t node_count(v1::FieldContract::Location location) const {
    if (location == v1::FieldContract::INTERFACE_NODES) return interface_nodes_;
    return location == v1::FieldContract::MESH_NODES ? mesh_nodes_ : 1;
  }

  void fail(Error error) {
    failure_ = std::move(error);
    state_ = ProtocolState::failed;
  }

  Solver& solver_;
  Transport& transport_;
  std::string run_id_;
  Description description_;
  ProtocolState state_ = ProtocolState::connected;
  std::uint64_t interface_nodes_ = 0, mesh_nodes_ = 0;
  double time_step_ = 0;
  std::optional<Error> failure_;
};

} // namespace

Result<ReplacedMesh> Solver::replace_mesh(const NewMesh&, bool) {
  return internal_error("this participant says that it can replace its mesh, but does not know how");
}

ServeOptions serve_options_from_environment(std::string endpoint) {
  ServeOptions options;
  options.endpoint = std::move(endpoint);
  options.participant = environment("DROGUE_PARTICIPANT");
  options.run_id = environment("DROGUE_RUN_ID");
  options.key_file = environment("DROGUE_KEY");
  options.coupler_key = environment("DROGUE_COUPLER_KEY");
  const std::string deadline = environment("DROGUE_PEER_DEADLINE");
  int seconds = 0;
  if (std::from_chars(deadline.data(), deadline.data() + deadline.size(), seconds).ec == std::errc{} &&
      seconds > 0)
    options.peer_deadline = std::chrono::seconds(seconds);
  return options;
}

Result<void> serve(Solver& solver, const ServeOptions& options) {
  if (options.participant.empty())
    return config_error("the name of the participant is not known: start it through the coupler, or set "
                        "DROGUE_PARTICIPANT to fluid, structure or mesh_mover");
  Transport transport(options);
  DROGUE_TRY(transport.start());
  return Server(solver, transport, options.run_id).run(options.peer_deadline);
}

v1::FieldContract field(std::string name, v1::FieldContract::Quantity quantity,
                        v1::FieldContract::Location location, std::uint32_t components,
                        v1::FieldContract::TimeLevel level, bool optional) {
  v1::FieldContract f;
  f.set_name(std::move(name));
  f.set_quantity(quantity);
  f.set_location(location);
  f.set_components(components);
  f.set_time_level(level);
  f.set_optional(optional);
  return f;
}

} // namespace drogue::participant
