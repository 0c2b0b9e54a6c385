// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/scheme/participants.hpp"

#include <algorithm>
#include <array>

#include "coupler/scheme/contract.hpp"
#include "coupler/scheme/joined_interface.hpp"

namespace drogue::coupler {
namespace {

using launcher::Peer;
using launcher::Seconds;
using participant::Fields;
using participant::ProtocolState;

wire::Message message(const Station& at) {
  wire::Message m;
  m.envelope.set_step(at.step);
  m.envelope.set_iteration(at.iteration);
  m.envelope.set_attempt(at.attempt);
  return m;
}

MeshSize size_of(const participant::InterfaceMesh& mesh) {
  return {mesh.points.size() / 3, mesh.mesh_node_count};
}

/// Outputs that the coupling cannot do without, even if a participant declares them optional.
bool needed(const std::string& output) {
  return output == "displacement" || output == "velocity" || output == "mesh_displacement";
}

} // namespace

Result<void> Participants::begin_step(const Station& at, double time, double time_step) {
  for (Peer* peer : everyone()) {
    wire::Message m = message(at);
    m.envelope.mutable_begin_step()->set_time(time);
    m.envelope.mutable_begin_step()->set_time_step(time_step);
    DROGUE_TRY(hub_->post(*peer, std::move(m)));
  }
  for (Peer* peer : everyone()) DROGUE_TRY(hub_->await(*peer, Seconds(settings_.deadlines.iterate)));
  return {};
}

Result<void> Participants::commit(const Station& at, bool write_output) {
  for (Peer* peer : everyone()) {
    wire::Message m = message(at);
    m.envelope.mutable_commit()->set_write_output(write_output);
    DROGUE_TRY(hub_->post(*peer, std::move(m)));
  }
  new_mesh_.reset();
  for (Peer* peer : everyone()) {
    // A mesh mover may make a new mesh of it.
    const double deadline = peer == mesh_mover_ && peer->hello.can_replace_mesh()
                                ? settings_.deadlines.initialize
                                : settings_.deadlines.other;
    const auto answer = hub_->await(*peer, Seconds(deadline));
    if (!answer) return answer.error();
    if (peer == mesh_mover_ && answer->envelope.done().has_new_mesh())
      new_mesh_ = answer->envelope.done().new_mesh();
  }
  return {};
}

Result<MeshChange> Participants::replace_mesh(const Station& at, const MeshFile& mesh, bool restoring) {
  const std::array both{mesh_mover_, fluid_};
  for (const Peer* peer : both)
    if (!peer->hello.can_replace_mesh())
      return config_error(
          "the mesh must be replaced{}, but {} ({}) cannot take another mesh: it does not say "
          "can_replace_mesh in its Hello",
          new_mesh_ ? fmt::format(" after step {} ({})", at.step, new_mesh_->reason()) : "", peer->name,
          peer->hello.software());
  for (Peer* peer : both) {
    wire::Message m = message(at);
    m.envelope.mutable_replace_mesh()->set_file(mesh.path.string());
    m.envelope.mutable_replace_mesh()->set_mesh_hash(mesh.mesh_hash);
    m.envelope.mutable_replace_mesh()->set_restoring(restoring);
    DROGUE_TRY(hub_->post(*peer, std::move(m)));
  }
  const participant::InterfaceMesh old_fluid = fluid_interface, old_mesh = mesh_interface;
  MeshChange change;
  change.nodes_before = fluid_interface.mesh_node_count;
  for (Peer* peer : both) {
    const auto answer = hub_->await(*peer, Seconds(settings_.deadlines.initialize));
    if (!answer) return answer.error();
    const v1::Replaced& replaced = answer->envelope.replaced();
    participant::InterfaceMesh& interface = peer == fluid_ ? fluid_interface : mesh_interface;
    interface.mesh_node_count = replaced.mesh_node_count();
    interface.mesh_hash = replaced.mesh_hash();
    if (const auto nodes = answer->indices.find("mesh_nodes"); nodes != answer->indices.end())
      interface.mesh_nodes = nodes->second.values;
    if (peer == fluid_) {
      change.mass_defect = replaced.mass_defect();
      change.momentum_defect = replaced.momentum_defect();
      change.energy_defect = replaced.energy_defect();
    }
  }
  change.nodes_after = fluid_interface.mesh_node_count;
  DROGUE_TRY(check_same_mesh(fluid_interface, mesh_interface));
  DROGUE_TRY(check_same_pairs({old_fluid, old_mesh}, {fluid_interface, mesh_interface}));
  replaced_mesh_ = mesh;
  return change;
}

Result<void> Participants::roll_back(const Station& at) {
  for (Peer* peer : everyone()) {
    if (peer->state != ProtocolState::in_step && peer->state != ProtocolState::iterated) continue;
    wire::Message m = message(at);
    m.envelope.mutable_rollback();
    DROGUE_TRY(hub_->ask(*peer, std::move(m), Seconds(settings_.deadlines.other)));
  }
  return {};
}

Result<void> Participants::checkpoint(const Station& at, const std::filesystem::path& directory) {
  for (Peer* peer : everyone()) {
    const auto own = directory / peer->name;
    std::error_code failure;
    std::filesystem::create_directories(own, failure);
    if (failure) return internal_error("cannot make the folder {}: {}", own.string(), failure.message());
    wire::Message m = message(at);
    m.envelope.mutable_checkpoint()->set_directory(own.string());
    DROGUE_TRY(hub_->post(*peer, std::move(m)));
  }
  for (Peer* peer : everyone()) DROGUE_TRY(hub_->await(*peer, Seconds(settings_.deadlines.other)));
  return {};
}

Result<void> Participants::restore(const Station& at, const std::filesystem::path& directory) {
  for (Peer* peer : everyone()) {
    wire::Message m = message(at);
    m.envelope.mutable_restore()->set_directory((directory / peer->name).string());
    DROGUE_TRY(hub_->post(*peer, std::move(m)));
  }
  for (Peer* peer : everyone()) DROGUE_TRY(hub_->await(*peer, Seconds(settings_.deadlines.other)));
  return {};
}

std::vector<Peer*> Participants::everyone() const {
  std::vector<Peer*> all;
  for (const Structure& structure : structures_) all.push_back(structure.peer);
  all.insert(all.end(), {mesh_mover_, fluid_});
  return all;
}

const ParticipantSettings& Participants::settings_of(const Peer& peer) const {
  for (const ParticipantSettings& structure : settings_.structures)
    if (structure.name == peer.name) return structure;
  return &peer == fluid_ ? settings_.fluid : settings_.mesh_mover;
}

bool Participants::structure_takes_traction() const {
  return std::any_of(structures_.begin(), structures_.end(), [](const Structure& structure) {
    return find_input(structure.peer->hello, "traction") != nullptr;
  });
}

std::string Participants::who_cannot_checkpoint() const {
  for (const Peer* peer : everyone())
    if (!peer->hello.can_checkpoint() || !settings_of(*peer).directory.empty()) return peer->name;
  return {};
}

std::string Participants::who_cannot_roll_back() const {
  for (const Peer* peer : everyone())
    if (!peer->hello.can_rollback()) return peer->name;
  return {};
}

Result<void> Participants::begin_iterate(Peer& peer, const Station& at, Fields inputs) {
  wire::Message m = message(at);
  m.envelope.mutable_iterate();
  for (auto& [name, array] : inputs)
    if (find_input(peer.hello, name)) m.floats[name] = std::move(array);
  return hub_->post(peer, std::move(m));
}

Result<Fields> Participants::end_iterate(Peer& peer, const MeshSize& size, v1::Iterated& report) {
  auto answer = hub_->await(peer, Seconds(settings_.deadlines.iterate));
  if (!answer) return answer.error();
  report = answer->envelope.iterated();
  for (const v1::FieldContract& output : peer.hello.output()) {
    const auto it = answer->floats.find(output.name());
    if (it == answer->floats.end()) {
      if (output.optional() && output.name() != load_field_ && !needed(output.name())) continue;
      return peer_error("{} gave no \"{}\"", peer.name, output.name());
    }
    if (const auto bad = wire::first_not_finite(it->second.values))
      return retryable_error("{} gave a \"{}\" that is not finite at value {}", peer.name, output.name(),
                             *bad);
    DROGUE_TRY(check_shape(peer.name, output, it->second, size));
  }
  return std::move(answer->floats);
}

std::string Participants::inner_trouble(double residual) const {
  std::vector<std::pair<std::string, const v1::Iterated*>> reports{{"mesh_mover", &mesh_report_},
                                                                   {"fluid", &fluid_report_}};
  for (const Structure& structure : structures_)
    reports.emplace_back(structure.peer->name, &structure.report);
  for (const auto& [name, report] : reports) {
    if (report->converged() || (report->fixed_iterations() && report->inner_residual() <= residual)) continue;
    return fmt::format(
        "the {}'s own iteration did not converge (residual {:.2e} of the step's first after {} "
        "iterations)",
        name, report->inner_residual(), report->inner_iterations());
  }
  return {};
}

v1::Iterated Participants::structure_report() const {
  v1::Iterated worst = structures_.front().report;
  for (const Structure& structure : structures_) {
    worst.set_inner_iterations(std::max(worst.inner_iterations(), structure.report.inner_iterations()));
    worst.set_inner_residual(std::max(worst.inner_residual(), structure.report.inner_residual()));
  }
  return worst;
}

Result<void> Participants::begin_structure(const Station& at, Fields inputs) {
  if (structures_.size() == 1) return begin_iterate(*structures_[0].peer, at, std::move(inputs));
  for (const Structure& structure : structures_) {
    Fields own;
    for (const auto& [name, array] : inputs)
      own[name] = rows_of(array, structure.first_node, structure.size.interface_nodes);
    DROGUE_TRY(begin_iterate(*structure.peer, at, std::move(own)));
  }
  return {};
}

/// An error is given when all of them have answered: a rollback may follow.
Result<Fields> Participants::end_structure() {
  if (structures_.size() == 1)
    return end_iterate(*structures_[0].peer, structures_[0].size, structures_[0].report);
  Fields all;
  std::optional<Error> error;
  for (Structure& structure : structures_) {
    const auto own = end_iterate(*structure.peer, structure.size, structure.report);
    if (!own && (!error || error->retryable)) error = own.error();
    if (error) continue;
    for (const char* name : {"displacement", "velocity"}) append_rows(all[name], own->at(name));
  }
  if (error) return *error;
  return all;
}

Result<Fields> Participants::mesh_mover(const Station& at, Fields inputs) {
  DROGUE_TRY(begin_iterate(*mesh_mover_, at, std::move(inputs)));
  return end_iterate(*mesh_mover_, size_of(mesh_interface), mesh_report_);
}
Result<Fields> Participants::fluid(const Station& at, Fields inputs) {
  DROGUE_TRY(begin_iterate(*fluid_, at, std::move(inputs)));
  return end_iterate(*fluid_, size_of(fluid_interface), fluid_report_);
}

} // namespace drogue::coupler
