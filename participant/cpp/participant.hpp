// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "drogue/v1/wire.pb.h"

/// The SDK of a Drogue participant: derive from Solver, call serve(). Our own solvers use nothing else.
///
///   CONNECTED --Hello--> GREETED --Configure--> CONFIGURED --Initialize--> READY
///   READY --BeginStep--> IN_STEP --Iterate--> ITERATED --Iterate--> ITERATED --Commit--> READY
///                        IN_STEP, ITERATED --Rollback--> READY
///   READY --Checkpoint--> READY      READY --Restore--> READY      READY --ReplaceMesh--> READY
///   Shutdown and Abort from anywhere; after an error that is not retryable: FAILED.
/// The table itself stands in participant/cpp/protocol_state.cpp.
namespace drogue::participant {

/// Values that cross the wire, row-major. A field is {nodes, components}.
struct FloatArray {
  std::vector<std::uint64_t> shape;
  std::vector<double> values;
};
struct IndexArray {
  std::vector<std::uint64_t> shape;
  std::vector<std::int64_t> values;
};

/// Fields by name.
using Fields = std::map<std::string, FloatArray>;

/// What a participant says of itself before anything is computed.
struct Description {
  std::string software;
  bool can_rollback = true;
  bool can_checkpoint = false;
  bool variable_step = true;
  bool can_replace_mesh = false;
  std::vector<v1::FieldContract> inputs;
  std::vector<v1::FieldContract> outputs;
  /// Process ids of all ranks; empty: this process.
  std::vector<std::int64_t> pids;
};

/// The surface that exchanges, and the identity of the whole mesh. See Initialized in wire.proto.
struct InterfaceMesh {
  /// {n, 3}: positions at Initialize.
  std::vector<double> points;
  /// {n, 3} or empty: reference positions, and coordinates in which surfaces are matched.
  std::vector<double> reference;
  std::vector<double> material;
  /// {n, 3} or empty: velocity at Initialize, of a structure that does not start at rest.
  std::vector<double> velocity;
  /// {m, nodes of the element}: indices into points, in Gmsh's order (corners, mid-sides, centre). Lines are
  /// the interface of a plane problem, faces that of one in space. On a fluid the normal points into the
  /// wall; that of a line lies to the right of its direction.
  std::vector<std::int64_t> lines;
  std::vector<std::int64_t> lines3;
  std::vector<std::int64_t> triangles;
  std::vector<std::int64_t> triangles6;
  std::vector<std::int64_t> quadrangles4;
  std::vector<std::int64_t> quadrangles9;
  /// {n}: index of each interface node in the whole mesh.
  std::vector<std::int64_t> mesh_nodes;
  std::uint64_t mesh_node_count = 0;
  std::string mesh_hash;
};

/// The arrays of elements that an interface may have, as they are named on the wire.
struct ElementArray {
  const char* name;
  std::uint64_t nodes; ///< of an element
  std::vector<std::int64_t> InterfaceMesh::*elements;
};
inline constexpr std::array<ElementArray, 6> element_arrays{
    {{"lines", 2, &InterfaceMesh::lines},
     {"lines3", 3, &InterfaceMesh::lines3},
     {"triangles", 3, &InterfaceMesh::triangles},
     {"triangles6", 6, &InterfaceMesh::triangles6},
     {"quadrangles4", 4, &InterfaceMesh::quadrangles4},
     {"quadrangles9", 9, &InterfaceMesh::quadrangles9}}};

struct RunInfo {
  std::filesystem::path directory;
  double start_time = 0;
  double time_step = 0;
  /// The folder holds the results of the part of this run that was done before: they stay. restore() follows
  /// initialize() and says where they go on.
  bool resume = false;
};

struct StepInfo {
  std::uint64_t step = 0;
  std::uint32_t attempt = 0;
  double time = 0; ///< t_n
  double time_step = 0;
};

struct IterationReport {
  std::uint32_t inner_iterations = 0;
  double inner_residual = 0;
  bool converged = true;
  /// A fixed number of iterations in each call: the coupler judges inner_residual in place of converged.
  bool fixed_iterations = false;
};

/// A mesh that should take the place of a fluid's mesh; see NewMesh in wire.proto.
struct NewMesh {
  std::filesystem::path file; ///< absolute
  std::string mesh_hash;
  std::string reason;
};

/// What a participant holds after replace_mesh; see Replaced in wire.proto.
struct ReplacedMesh {
  std::vector<std::int64_t> mesh_nodes; ///< {n}: of each interface node, in the order of initialize()
  std::uint64_t mesh_node_count = 0;
  std::string mesh_hash;
  /// Of a fluid, relative: by how much carrying the flow over changed flux, momentum and kinetic energy.
  double mass_defect = 0;
  double momentum_defect = 0;
  double energy_defect = 0;
};

/// A participant's solver. serve() calls the functions in the order of the state table above, from one
/// thread.
///
/// Contract: `iterate` is deterministic: from the same begin_step state, the same sequence of inputs gives
/// the same sequence of outputs to the bit; `rollback` restores exactly the state at begin_step. An error of
/// kind numerical with `retryable` leaves the solver ready for rollback; any other error ends the
/// participant.
class Solver {
 public:
  virtual ~Solver() = default;

  /// @pre none: called once, before anything else  @post changes nothing
  [[nodiscard]] virtual Description describe() = 0;
  /// @pre called once, after describe  @post results go into run.directory
  [[nodiscard]] virtual Result<void> configure(const RunInfo& run) = 0;
  /// Reads meshes and states, and gives the interface.
  /// @pre called once, after configure  @post READY: begin_step may follow; so may restore
  [[nodiscard]] virtual Result<InterfaceMesh> initialize() = 0;
  /// Saves what rollback needs.
  /// @pre READY  @post in the step, whose length is step.time_step; the state is that at step.time
  [[nodiscard]] virtual Result<void> begin_step(const StepInfo& step) = 0;
  /// One solve to t_{n+1}.
  /// @pre in the step; `inputs` holds every required field of the contract, shapes and finiteness checked
  /// @post `outputs` holds every field of the contract that is not optional, with finite values
  [[nodiscard]] virtual Result<IterationReport> iterate(const Fields& inputs, Fields& outputs) = 0;
  /// Makes the last iterate the state at t_{n+1}; writes results when told.
  /// @pre after an iterate of this step  @post READY
  [[nodiscard]] virtual Result<void> commit(bool write_output) = 0;
  /// @pre in the step; called only with Description::can_rollback  @post READY, in exactly the state at
  /// begin_step
  [[nodiscard]] virtual Result<void> rollback() = 0;
  /// Asked of a mesh mover after every commit: the mesh that should take the place of its own, which is no
  /// longer good enough.
  [[nodiscard]] virtual std::optional<NewMesh> new_mesh() { return std::nullopt; }
  /// Goes over to another mesh of the same domain and boundaries, between two steps; see ReplaceMesh in
  /// wire.proto. `restoring`: restore() follows, and brings the state.
  [[nodiscard]] virtual Result<ReplacedMesh> replace_mesh(const NewMesh& mesh, bool restoring);
  /// Saves what the steps to come depend on into files of any names in `directory`.
  /// @pre READY; called only with can_checkpoint; `directory` exists, is empty and the solver's own
  /// @post the files are complete; the solver's state has not changed
  [[nodiscard]] virtual Result<void> checkpoint(const std::filesystem::path& directory) = 0;
  /// The exact state at checkpoint() again. In a run with RunInfo::resume it also cuts series of results to
  /// their length at the checkpoint, and continues them.
  /// @pre READY; checkpoint() of this or another process of this solver wrote `directory`  @post READY
  [[nodiscard]] virtual Result<void> restore(const std::filesystem::path& directory) = 0;
};

struct ServeOptions {
  /// Where the coupler listens, e.g. "ipc:///tmp/drogue-x/coupler" or "tcp://127.0.0.1:5555".
  std::string endpoint;
  /// "fluid", "structure" or "mesh_mover"; default: environment variable DROGUE_PARTICIPANT.
  std::string participant;
  /// Default: environment variable DROGUE_RUN_ID.
  std::string run_id;
  /// Longest silence of the coupler before giving up (exit status 4); default: DROGUE_PEER_DEADLINE in
  /// seconds, else one hour.
  std::chrono::seconds peer_deadline{3600};
  /// For a coupler on another machine, which must have keys (`coupler keygen`): the file of this
  /// participant's own pair, and the coupler's public key as text; defaults: DROGUE_KEY and
  /// DROGUE_COUPLER_KEY.
  std::string key_file = {};
  std::string coupler_key = {};
};

/// Reads participant, run id, deadline and keys from the environment that the coupler's launcher sets (or
/// prints, for a participant that is started by hand).
[[nodiscard]] ServeOptions serve_options_from_environment(std::string endpoint);

/// Connects and serves until Shutdown (ok), Abort, an error, or silence beyond the deadline.
/// Wait is passive: no spinning while the coupler works.
[[nodiscard]] Result<void> serve(Solver& solver, const ServeOptions& options);

/// What the solver does, for the beats: may be called from inside iterate() at any rate; cheap.
void report_progress(const char* phase, std::uint32_t inner_iteration = 0, double inner_residual = 0);

/// Shorthand for a contract entry.
[[nodiscard]] v1::FieldContract field(std::string name, v1::FieldContract::Quantity quantity,
                                      v1::FieldContract::Location location, std::uint32_t components,
                                      v1::FieldContract::TimeLevel level = v1::FieldContract::END_OF_STEP,
                                      bool optional = false);

} // namespace drogue::participant
