// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "coupler/checkpoint_store.hpp"
#include "coupler/launcher/peer.hpp"
#include "coupler/scheme/contract.hpp"
#include "coupler/settings.hpp"
#include "participant/cpp/participant.hpp"

namespace drogue::coupler {

/// Where the coupled run stands: what every request carries.
struct Station {
  std::uint64_t step = 0;
  std::uint32_t iteration = 0;
  std::uint32_t attempt = 1;
};

/// What came of a mesh's replacement; the defects are those of Replaced in wire.proto.
struct MeshChange {
  std::uint64_t nodes_before = 0, nodes_after = 0;
  double mass_defect = 0, momentum_defect = 0, energy_defect = 0;
};

/// The participants of a case, as typed calls over the wire. Several structures act as one: fields on their
/// interfaces are one array, with the nodes of one after those of the other in the order of the case.
class Participants {
 public:
  /// Starts the processes (working directory RUN/NAME, log RUN/NAME.log), shakes hands, checks
  /// versions, capabilities and field contracts, and initialises them side by side. `resume`: their results
  /// of an earlier part stay, and restore() follows. `witness` sees every message; or nullptr. A participant
  /// that is started by hand is waited for, and the command that starts it printed.
  [[nodiscard]] static Result<std::unique_ptr<Participants>>
  launch(const CaseSettings& settings, const std::filesystem::path& run_directory, bool resume = false,
         launcher::Witness* witness = nullptr);

  /// The interface each gave at Initialize.
  participant::InterfaceMesh fluid_interface, structure_interface, mesh_interface;

  [[nodiscard]] Result<void> begin_step(const Station& at, double time, double time_step);
  /// Everyone; `write_output`: their own output intervals count this step.
  [[nodiscard]] Result<void> commit(const Station& at, bool write_output);
  /// The mesh that the mesh mover gave with its last commit to take the place of the present one.
  [[nodiscard]] const std::optional<v1::NewMesh>& new_mesh() const { return new_mesh_; }
  /// Fluid and mesh mover go over to another mesh, between two steps; `restoring`: restore() follows. Errors:
  /// one of them cannot (ErrorKind::config), or holds another mesh or another interface afterwards.
  [[nodiscard]] Result<MeshChange> replace_mesh(const Station& at, const MeshFile& mesh, bool restoring);
  /// The mesh that replace_mesh gave last.
  [[nodiscard]] const std::optional<MeshFile>& replaced_mesh() const { return replaced_mesh_; }
  /// Everyone that is in the step goes back to its beginning.
  [[nodiscard]] Result<void> roll_back(const Station& at);

  /// Everyone, between two steps: each into, or from, DIRECTORY/NAME. @pre nobody is in
  /// who_cannot_checkpoint()
  [[nodiscard]] Result<void> checkpoint(const Station& at, const std::filesystem::path& directory);
  [[nodiscard]] Result<void> restore(const Station& at, const std::filesystem::path& directory);
  /// Who lacks a capability; empty when all have it.
  [[nodiscard]] std::string who_cannot_checkpoint() const;
  [[nodiscard]] std::string who_cannot_roll_back() const;

  /// One solve: sends `inputs` (only those that the participant's contract names) and gives its outputs.
  [[nodiscard]] Result<participant::Fields> mesh_mover(const Station& at, participant::Fields inputs);
  [[nodiscard]] Result<participant::Fields> fluid(const Station& at, participant::Fields inputs);

  /// The structures' solve in two halves, in which they work side by side, for another one in between. What
  /// was begun must be ended.
  [[nodiscard]] Result<void> begin_structure(const Station& at, participant::Fields inputs);
  [[nodiscard]] Result<participant::Fields> end_structure();

  /// What a solver said of its own iteration in its last solve.
  [[nodiscard]] const v1::Iterated& fluid_report() const { return fluid_report_; }
  /// Of several structures the most iterations and the largest residual.
  [[nodiscard]] v1::Iterated structure_report() const;

  /// Why the last solves may not end a step; empty when they may. A solver that iterates to its
  /// own tolerance must have met it; one that does a fixed number of iterations must have its residual at or
  /// below `residual`, relative to the first of the step, or its own tolerance.
  [[nodiscard]] std::string inner_trouble(double residual) const;

  /// The load the fluid offers at the time level that the case asks for: name of its output.
  [[nodiscard]] const std::string& load_field() const { return load_field_; }
  [[nodiscard]] bool load_is_pressure() const { return load_is_pressure_; }
  /// What the structure takes of it; never LoadTime::matching.
  [[nodiscard]] LoadTime load_time() const { return load_time_; }

  /// Whether a structure asks for the "traction" as well as, or in place of, the nodal forces.
  [[nodiscard]] bool structure_takes_traction() const;

  [[nodiscard]] launcher::Hub& hub() { return *hub_; }

 private:
  /// A structure, and its nodes among those of all.
  struct Structure {
    launcher::Peer* peer = nullptr;
    std::size_t first_node = 0;
    MeshSize size;
    v1::Iterated report;
  };
  explicit Participants(const CaseSettings& settings) : settings_(settings) {}
  [[nodiscard]] Result<void> start(const ParticipantSettings& p, const std::filesystem::path& run_directory,
                                   launcher::Peer*& peer);
  [[nodiscard]] Result<void> expect(const ParticipantSettings& p, launcher::Peer*& peer);
  [[nodiscard]] Result<void> await_hello();
  [[nodiscard]] const ParticipantSettings& settings_of(const launcher::Peer& peer) const;
  [[nodiscard]] Result<void> check_contracts();
  [[nodiscard]] Result<void> choose_load();
  [[nodiscard]] Result<void> configure(const std::filesystem::path& run_directory, bool resume);
  [[nodiscard]] Result<void> initialize();
  void join_structures(std::map<const launcher::Peer*, participant::InterfaceMesh>& meshes);
  [[nodiscard]] Result<void> begin_iterate(launcher::Peer& peer, const Station& at,
                                           participant::Fields inputs);
  [[nodiscard]] Result<participant::Fields> end_iterate(launcher::Peer& peer, const MeshSize& size,
                                                        v1::Iterated& report);
  [[nodiscard]] std::vector<launcher::Peer*> everyone() const;

  const CaseSettings& settings_;
  std::unique_ptr<launcher::Hub> hub_;
  launcher::Peer *fluid_ = nullptr, *mesh_mover_ = nullptr;
  std::vector<Structure> structures_;
  v1::Iterated fluid_report_, mesh_report_;
  std::optional<v1::NewMesh> new_mesh_;
  std::optional<MeshFile> replaced_mesh_;
  std::string load_field_;
  bool load_is_pressure_ = true;
  LoadTime load_time_ = LoadTime::matching;
};

} // namespace drogue::coupler
