// SPDX-License-Identifier: GPL-3.0-or-later
// Participants up to the first step: started or waited for, asked who they are, and initialised.
#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <random>

#include <spdlog/spdlog.h>
#include <unistd.h>

#include "coupler/participant_command.hpp"
#include "coupler/scheme/contract.hpp"
#include "coupler/scheme/joined_interface.hpp"
#include "coupler/scheme/participants.hpp"

namespace drogue::coupler {
namespace {

using launcher::Peer;
using launcher::Seconds;

wire::Message first_message() {
  wire::Message m;
  m.envelope.set_attempt(Station{}.attempt);
  return m;
}

std::string new_run_id() {
  std::random_device source;
  return fmt::format("{:08x}{:08x}", source(), source());
}

/// What only a run gives: its identity, and the longest time the others may keep a participant waiting,
/// twice.
std::vector<std::string> run_environment(const ParticipantSettings& p, const CaseSettings& settings,
                                         const std::string& run_id) {
  const DeadlineSettings& d = settings.deadlines;
  const auto everyone = participants_of(settings);
  const bool by_hand =
      std::any_of(everyone.begin(), everyone.end(), [](const auto* other) { return other->by_hand; });
  std::vector<std::string> e{
      "DROGUE_RUN_ID=" + run_id,
      fmt::format("DROGUE_PEER_DEADLINE={:.0f}",
                  2 * (d.connect + d.initialize + 3 * d.iterate + d.other + (by_hand ? d.by_hand : 0)))};
  // A plain process that calls MPI_Init would start a daemon of its own otherwise.
  if (p.ranks == 1) e.push_back("OMPI_MCA_ess_singleton_isolated=1");
  const std::vector<std::string> always = participant_environment(p);
  e.insert(e.end(), always.begin(), always.end());
  return e;
}

Result<launcher::Door> door_of(const CaseSettings& settings) {
  launcher::Door door;
  for (const ParticipantSettings* p : participants_of(settings)) {
    if (!p->by_hand) continue;
    door.endpoint = settings.network.endpoint;
    if (p->public_key.empty()) continue;
    const auto key = keys::read_public(p->public_key);
    if (!key) return key.error();
    if (!door.allowed.emplace(*key, p->name).second)
      return config_error("{}: this key is another participant's: each needs one of its own",
                          p->public_key.string());
  }
  if (settings.network.key.empty()) return door;
  auto own = keys::read_pair(settings.network.key);
  if (!own) return own.error();
  door.key = std::move(*own);
  return door;
}

/// Where participants connect: as the case says, else where the coupler listens, by its machine's name.
std::string public_endpoint(const NetworkSettings& network, const std::string& bound) {
  if (!network.connect.empty()) return network.connect;
  const std::string everywhere = "tcp://0.0.0.0:";
  if (bound.rfind(everywhere, 0) != 0) return bound;
  std::array<char, 256> host{};
  gethostname(host.data(), host.size() - 1);
  return fmt::format("tcp://{}:{}", host.data(), bound.substr(everywhere.size()));
}

Result<participant::InterfaceMesh> interface_of(const Peer& peer, const wire::Message& answer) {
  participant::InterfaceMesh mesh;
  const auto floats = [&](const char* name, std::vector<double>& to) {
    if (const auto it = answer.floats.find(name); it != answer.floats.end()) to = it->second.values;
  };
  const auto indices = [&](const char* name, std::vector<std::int64_t>& to) {
    if (const auto it = answer.indices.find(name); it != answer.indices.end()) to = it->second.values;
  };
  floats("points", mesh.points);
  floats("reference", mesh.reference);
  floats("material", mesh.material);
  floats("velocity", mesh.velocity);
  for (const auto& array : participant::element_arrays) indices(array.name, mesh.*array.elements);
  indices("mesh_nodes", mesh.mesh_nodes);
  mesh.mesh_node_count = answer.envelope.initialized().mesh_node_count();
  mesh.mesh_hash = answer.envelope.initialized().mesh_hash();

  const std::size_t n = mesh.points.size();
  const auto bad = [&](const char* what) {
    return peer_error("{} gave an interface that does not hold together: {}", peer.name, what);
  };
  if (n == 0 || n % 3 != 0) return bad("points must be {n, 3} with n > 0");
  if (!mesh.reference.empty() && mesh.reference.size() != n)
    return bad("reference must have the shape of points");
  if (!mesh.material.empty() && mesh.material.size() != n)
    return bad("material must have the shape of points");
  if (!mesh.velocity.empty() && mesh.velocity.size() != n)
    return bad("velocity must have the shape of points");
  if (const auto value = wire::first_not_finite(mesh.velocity))
    return bad(fmt::format("velocity is not finite at node {}", *value / 3).c_str());
  const auto within = [](const std::vector<std::int64_t>& list, std::int64_t end) {
    return std::all_of(list.begin(), list.end(), [end](std::int64_t i) { return i >= 0 && i < end; });
  };
  const auto nodes = static_cast<std::int64_t>(n / 3);
  for (const auto& array : participant::element_arrays) {
    if ((mesh.*array.elements).size() % array.nodes != 0)
      return bad(fmt::format("{} must be {{m, {}}}", array.name, array.nodes).c_str());
    if (!within(mesh.*array.elements, nodes)) return bad("an element names a missing node");
  }
  if (!within(mesh.mesh_nodes, static_cast<std::int64_t>(mesh.mesh_node_count)))
    return bad("mesh_nodes names a node beyond mesh_node_count");
  return mesh;
}

/// The fluid's load of a time level, of a quantity or of any; null: none.
const v1::FieldContract* find_load(const v1::Hello& fluid, v1::FieldContract::TimeLevel level,
                                   std::optional<v1::FieldContract::Quantity> quantity = {}) {
  using C = v1::FieldContract;
  for (const C& output : fluid.output()) {
    const bool pressure = output.quantity() == C::PRESSURE && output.components() == 1;
    const bool traction = output.quantity() == C::TRACTION && output.components() == 3;
    if (output.time_level() == level && output.location() == C::INTERFACE_NODES && (pressure || traction) &&
        (!quantity || output.quantity() == *quantity))
      return &output;
  }
  return nullptr;
}

} // namespace

Result<std::unique_ptr<Participants>> Participants::launch(const CaseSettings& settings,
                                                           const std::filesystem::path& run_directory,
                                                           bool resume, launcher::Witness* witness) {
  std::unique_ptr<Participants> p(new Participants(settings));
  const auto door = door_of(settings);
  if (!door) return door.error();
  auto hub = launcher::Hub::create(new_run_id(), *door, witness);
  if (!hub) return hub.error();
  p->hub_ = std::move(*hub);
  // Whatever fails from here on, the others are told why and nobody is left behind.
  const auto all = [&]() -> Result<void> {
    p->structures_.resize(settings.structures.size());
    for (std::size_t i = 0; i < p->structures_.size(); ++i)
      DROGUE_TRY(p->start(settings.structures[i], run_directory, p->structures_[i].peer));
    DROGUE_TRY(p->start(settings.mesh_mover, run_directory, p->mesh_mover_));
    DROGUE_TRY(p->start(settings.fluid, run_directory, p->fluid_));
    DROGUE_TRY(p->await_hello());
    DROGUE_TRY(p->check_contracts());
    DROGUE_TRY(p->configure(run_directory, resume));
    return p->initialize();
  };
  if (auto outcome = all(); !outcome) {
    p->hub_->abort(outcome.error().message);
    return outcome.error();
  }
  return p;
}

Result<void> Participants::start(const ParticipantSettings& p, const std::filesystem::path& run_directory,
                                 Peer*& peer) {
  if (p.by_hand && !p.directory.empty()) return expect(p, peer);
  launcher::Command command;
  auto a = run_command(p, hub_->endpoint());
  if (!a) return a.error();
  command.arguments = std::move(*a);
  command.environment = run_environment(p, settings_, hub_->run_id());
  command.directory = run_directory / p.name;
  command.log_file = run_directory / (p.name + ".log");
  std::error_code failure;
  std::filesystem::create_directories(command.directory, failure);
  if (failure)
    return config_error("cannot make the folder {}: {}", command.directory.string(), failure.message());
  if (p.by_hand) return expect(p, peer);
  auto started = hub_->start(p.name, command);
  if (!started) return started.error();
  peer = *started;
  spdlog::info("{} started, pid {}, log {}", p.name, peer->process->pid(), command.log_file.string());
  return {};
}

Result<void> Participants::expect(const ParticipantSettings& p, Peer*& peer) {
  peer = hub_->expect(p.name);
  std::vector<std::string> environment = run_environment(p, settings_, hub_->run_id());
  if (!p.public_key.empty()) {
    const auto own = keys::read_pair(settings_.network.key);
    if (!own) return own.error();
    environment.push_back("DROGUE_KEY=" +
                          std::filesystem::path(p.public_key).replace_extension(".key").string());
    environment.push_back("DROGUE_COUPLER_KEY=" + own->public_half);
  }
  const auto command = run_command(p, public_endpoint(settings_.network, hub_->door_endpoint()));
  if (!command) return command.error();
  spdlog::info("{} is started by hand, within {:g} s:\n{}", p.name, settings_.deadlines.by_hand,
               shell_line(environment, *command));
  return {};
}

/// Those that the coupler started first: they need not wait for a hand.
Result<void> Participants::await_hello() {
  for (const bool by_hand : {false, true})
    for (Peer* peer : everyone())
      if (!peer->process == by_hand)
        DROGUE_TRY(hub_->await_hello(
            *peer, Seconds(by_hand ? settings_.deadlines.by_hand : settings_.deadlines.connect)));
  return {};
}

Result<void> Participants::check_contracts() {
  for (Peer* peer : everyone()) {
    const v1::Hello& h = peer->hello;
    spdlog::info("{} is {}", peer->name, h.software());
    if (h.min_version() > wire::version || h.max_version() < wire::version)
      return peer_error("{} speaks protocol versions {} to {}, the coupler speaks {}", peer->name,
                        h.min_version(), h.max_version(), wire::version);
    if (settings_.loop.non_convergence == NonConvergence::retry && (!h.can_rollback() || !h.variable_step()))
      return config_error("loop.non_convergence is RETRY, but {} cannot {}", peer->name,
                          h.can_rollback() ? "change its step" : "roll back");
  }
  for (const Peer* peer : {mesh_mover_, fluid_}) DROGUE_TRY(check_role(peer->name, peer->name, peer->hello));
  for (const Structure& structure : structures_)
    DROGUE_TRY(check_role("structure", structure.peer->name, structure.peer->hello));
  return choose_load();
}

/// The load at the time level that the case asks for (loop.load). MATCHING: with MESH_RATE the mean; with
/// STRUCTURE_RATE the extrapolated mean of the load that the fluid gives at the end of the step, or else that
/// itself.
Result<void> Participants::choose_load() {
  using C = v1::FieldContract;
  const bool mesh_rate = settings_.loop.wall_velocity == WallVelocity::mesh_rate;
  if (mesh_rate && !find_input(fluid_->hello, "velocity_start"))
    return config_error("loop.wall_velocity is MESH_RATE, but the fluid takes no \"velocity_start\"");
  load_time_ = settings_.loop.load;
  const C* load = nullptr;
  if (load_time_ == LoadTime::matching && !mesh_rate) {
    const C* at_end = find_load(fluid_->hello, C::END_OF_STEP);
    load = at_end ? find_load(fluid_->hello, C::MEAN_OF_STEP, at_end->quantity())
                  : find_load(fluid_->hello, C::MEAN_OF_STEP);
    load_time_ = load ? LoadTime::extrapolated_mean : LoadTime::end_of_step;
    if (!load) load = at_end;
  } else {
    load = find_load(fluid_->hello, load_time_ == LoadTime::end_of_step ? C::END_OF_STEP : C::MEAN_OF_STEP);
  }
  if (!load)
    return config_error(
        "the fluid offers no pressure or traction on its interface nodes {}",
        load_time_ == LoadTime::end_of_step
            ? "at the end of the step"
            : "as the mean of the step, which loop.load MEAN_OF_STEP or loop.wall_velocity MESH_RATE "
              "ask for");
  load_field_ = load->name();
  load_is_pressure_ = load->quantity() == C::PRESSURE;
  spdlog::info("load: \"{}\"{}", load_field_,
               load_time_ == LoadTime::extrapolated_mean ? ", extrapolated to the end of the step" : "");
  return {};
}

Result<void> Participants::configure(const std::filesystem::path& run_directory, bool resume) {
  for (Peer* peer : everyone()) {
    wire::Message m = first_message();
    v1::Configure& c = *m.envelope.mutable_configure();
    c.set_version(wire::version);
    const std::filesystem::path own = settings_of(*peer).directory;
    c.set_directory((own.empty() ? run_directory / peer->name : own).string());
    c.set_start_time(0);
    c.set_time_step(settings_.time_step);
    c.set_resume(resume);
    DROGUE_TRY(hub_->post(*peer, std::move(m)));
  }
  for (Peer* peer : everyone()) DROGUE_TRY(hub_->await(*peer, Seconds(settings_.deadlines.other)));
  return {};
}

void Participants::join_structures(std::map<const Peer*, participant::InterfaceMesh>& meshes) {
  std::vector<participant::InterfaceMesh> all;
  std::size_t nodes = 0;
  for (Structure& structure : structures_) {
    participant::InterfaceMesh& mesh = all.emplace_back(std::move(meshes[structure.peer]));
    structure.first_node = nodes;
    structure.size = {mesh.points.size() / 3, mesh.mesh_node_count};
    nodes += structure.size.interface_nodes;
  }
  structure_interface = all.size() == 1 ? std::move(all[0]) : joined(all);
}

Result<void> Participants::initialize() {
  for (Peer* peer : everyone()) {
    wire::Message m = first_message();
    m.envelope.mutable_initialize();
    DROGUE_TRY(hub_->post(*peer, std::move(m)));
  }
  std::map<const Peer*, participant::InterfaceMesh> meshes;
  for (Peer* peer : everyone()) {
    auto answer = hub_->await(*peer, Seconds(settings_.deadlines.initialize));
    if (!answer) return answer.error();
    auto mesh = interface_of(*peer, *answer);
    if (!mesh) return mesh.error();
    meshes[peer] = std::move(*mesh);
  }
  fluid_interface = std::move(meshes[fluid_]);
  mesh_interface = std::move(meshes[mesh_mover_]);
  join_structures(meshes);
  return check_same_mesh(fluid_interface, mesh_interface);
}

} // namespace drogue::coupler
