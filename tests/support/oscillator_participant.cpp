// SPDX-License-Identifier: GPL-3.0-or-later
// Three participants with physics that can be solved by hand, for tests of the coupling itself. A rigid
// square plate of mass m an area on springs k an area, wetted on one side by a fluid that answers with its
// added mass m_a:
//   structure    m a + k d = f / A
//   fluid        p = -m_a a
//   mesh_mover   every node moves with the plate
// With --plane it is a plane problem: the plate is a line along x that moves along y, per unit depth.
// The trapezoidal rule in both makes the coupled steps those of the oscillator (m + m_a) a + k d = 0.
//
// usage: oscillator_participant ROLE [--delay SECONDS] [--refuse-steps-above DT] [--refuse-step N]
//                               [--second-rank yes]                           [--velocity V]
//                               [--fixed-residual R] [--checkpoints no] [--rolls-back no] [--plane yes]
//                               [--mistake apart|quantity|nan]
//                               [--new-mesh STEP] [--replaces-mesh yes]
//                               [--fault KIND --at REQUEST] --connect ENDPOINT
//                               (tests/support/faulty_solver.hpp)
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <memory>
#include <string>
#include <thread>

#include <unistd.h>

#include "participant/cpp/participant.hpp"
#include "tests/support/faulty_solver.hpp"

namespace {

using namespace drogue;
using namespace drogue::participant;
using C = v1::FieldContract;

constexpr double structure_mass = 0.5, spring = 40, added_mass = 5, initial_displacement = 0.01;
constexpr double initial_acceleration = -spring * initial_displacement / (structure_mass + added_mass);

struct Options {
  std::string role, endpoint;
  double delay = 0;                ///< seconds of "work" in every iterate
  double refuse_steps_above = 1e9; ///< a fluid that cannot do long steps (retryable error)
  std::uint64_t refused_step = 0;  ///< a fluid that fails in the first attempt of this step
  double velocity = 0;             ///< of the structure at the start
  /// A solver that says it does a fixed number of iterations, is not converged, and has this residual in the
  /// first three iterates of a step and none later; below 0: one that converges.
  double fixed_residual = -1;
  bool checkpoints = true, rolls_back = true; ///< whether it can
  bool plane = false;
  std::string mistake;
  std::uint64_t new_mesh_step = 0; ///< a mesh mover that offers another mesh after this step
  bool replaces_mesh = false;      ///< whether it can
  std::vector<std::int64_t> pids;  ///< this process and its second rank; empty without one
  test::Fault fault;
};

/// The unit square as a grid of n x n squares, two triangles each; n differs between the two sides.
InterfaceMesh plate(int n) {
  InterfaceMesh mesh;
  for (int j = 0; j <= n; ++j)
    for (int i = 0; i <= n; ++i) mesh.points.insert(mesh.points.end(), {double(i) / n, double(j) / n, 0.0});
  for (int j = 0; j < n; ++j)
    for (int i = 0; i < n; ++i) {
      const std::int64_t a = j * (n + 1) + i, b = a + 1, c = a + n + 1, d = c + 1;
      mesh.triangles.insert(mesh.triangles.end(), {a, b, d, a, d, c});
    }
  mesh.mesh_node_count = mesh.points.size() / 3;
  for (std::uint64_t i = 0; i < mesh.mesh_node_count; ++i)
    mesh.mesh_nodes.push_back(static_cast<std::int64_t>(i));
  return mesh;
}

/// The line from (1, 0) to (0, 0), with the fluid on its left, below: n elements of two or three nodes.
InterfaceMesh line(int n, bool three_nodes) {
  InterfaceMesh mesh;
  const int step = three_nodes ? 2 : 1;
  for (int i = step * n; i >= 0; --i) {
    mesh.mesh_nodes.push_back(static_cast<std::int64_t>(mesh.points.size() / 3));
    mesh.points.insert(mesh.points.end(), {double(i) / (step * n), 0.0, 0.0});
  }
  for (std::int64_t i = 0; i < step * n; i += step) {
    if (three_nodes)
      mesh.lines3.insert(mesh.lines3.end(), {i, i + 2, i + 1});
    else
      mesh.lines.insert(mesh.lines.end(), {i, i + 1});
  }
  mesh.mesh_node_count = mesh.points.size() / 3;
  return mesh;
}

/// Nodes of the plate on one side, with the trapezoidal rule's d, v, a across it.
class Plate : public Solver {
 public:
  Plate(Options options, int n)
      : options_(std::move(options)),
        mesh_(options_.plane ? line(n, options_.role == "structure") : plate(n)),
        across_(options_.plane ? 1 : 2) {}
  Result<void> configure(const RunInfo& run) override {
    directory_ = run.directory;
    return {};
  }
  Result<InterfaceMesh> initialize() override {
    if (options_.mistake == "apart")
      for (std::size_t i = 0; i < mesh_.points.size(); i += 3) mesh_.points[i] += 10;
    std::printf("plate of %zu nodes ready\n", static_cast<std::size_t>(mesh_.mesh_node_count));
    std::fflush(stdout);
    return mesh_;
  }
  Result<void> begin_step(const StepInfo& step) override {
    dt_ = step.time_step;
    step_ = step.step;
    refuses_ = step.step == options_.refused_step && step.attempt == 1;
    iterates_ = 0;
    return {};
  }
  Result<IterationReport> iterate(const Fields& in, Fields& out) override {
    std::this_thread::sleep_for(std::chrono::duration<double>(options_.delay));
    auto report = solve(in, out);
    if (report && options_.fixed_residual >= 0) {
      report->converged = false;
      report->fixed_iterations = true;
      report->inner_residual = ++iterates_ <= 3 ? options_.fixed_residual : 0;
    }
    return report;
  }
  Result<void> commit(bool) override {
    n_ = now_;
    return {};
  }
  std::optional<NewMesh> new_mesh() override {
    if (step_ != options_.new_mesh_step) return std::nullopt;
    std::ofstream(mesh_file()) << "two nodes in front";
    return NewMesh{mesh_file(), "two more", "worn after so many steps"};
  }
  /// The other mesh has two more nodes, in front of the interface's.
  Result<ReplacedMesh> replace_mesh(const NewMesh& mesh, bool) override {
    if (!std::ifstream(mesh.file)) return config_error("{} is not there", mesh.file.string());
    more_nodes_ = 2;
    ReplacedMesh replaced{mesh_.mesh_nodes, nodes() + more_nodes_, mesh.mesh_hash, 0.01, 0.02, 0.03};
    for (std::int64_t& node : replaced.mesh_nodes) node += 2;
    return replaced;
  }
  Result<void> rollback() override {
    now_ = n_;
    return {};
  }
  /// The motion's three numbers, to the bit.
  Result<void> checkpoint(const std::filesystem::path& directory) override {
    std::ofstream stream(directory / "plate", std::ios::binary);
    stream.write(reinterpret_cast<const char*>(&n_), sizeof n_);
    return stream ? Result<void>() : internal_error("cannot write the plate's state");
  }
  Result<void> restore(const std::filesystem::path& directory) override {
    std::ifstream stream(directory / "plate", std::ios::binary);
    stream.read(reinterpret_cast<char*>(&n_), sizeof n_);
    now_ = n_;
    return stream ? Result<void>() : config_error("cannot read the plate's state");
  }

 protected:
  struct Motion {
    double d = 0, v = 0, a = 0;
  };
  virtual Result<IterationReport> solve(const Fields& in, Fields& out) = 0;
  [[nodiscard]] Description described(const char* software) const {
    Description d;
    d.software = software;
    d.can_checkpoint = options_.checkpoints;
    d.can_rollback = options_.rolls_back;
    d.can_replace_mesh = options_.replaces_mesh;
    return d;
  }
  [[nodiscard]] std::uint64_t nodes() const { return mesh_.mesh_node_count; }
  [[nodiscard]] std::filesystem::path mesh_file() const { return directory_ / "other.msh"; }
  [[nodiscard]] FloatArray across(double value) const {
    FloatArray a{{nodes(), 3}, std::vector<double>(3 * nodes(), 0.0)};
    for (std::size_t i = across_; i < a.values.size(); i += 3) a.values[i] = value;
    return a;
  }
  Options options_;
  InterfaceMesh mesh_;
  std::size_t across_; ///< component of the motion
  double dt_ = 0;
  bool refuses_ = false;
  int iterates_ = 0; ///< of the step
  std::filesystem::path directory_;
  std::uint64_t step_ = 0;
  std::uint64_t more_nodes_ = 0; ///< of the mesh that replaced the first
  Motion n_, now_;
};

class Structure : public Plate {
 public:
  explicit Structure(Options o) : Plate(std::move(o), 5) {
    n_ = now_ = {initial_displacement, options_.velocity, initial_acceleration};
    if (n_.v != 0) mesh_.velocity = across(n_.v).values;
  }
  Description describe() override {
    Description d = described("oscillator structure");
    d.inputs = {
        field("force", options_.mistake == "quantity" ? C::TRACTION : C::FORCE, C::INTERFACE_NODES, 3)};
    d.outputs = {field("displacement", C::DISPLACEMENT, C::INTERFACE_NODES, 3),
                 field("velocity", C::VELOCITY, C::INTERFACE_NODES, 3)};
    return d;
  }

 protected:
  Result<IterationReport> solve(const Fields& in, Fields& out) override {
    double force = 0;
    const auto& f = in.at("force").values;
    for (std::size_t i = across_; i < f.size(); i += 3) force += f[i];
    // d = d_n + dt v_n + dt^2/4 (a_n + a),  m a + k d = f
    const double guess = n_.d + dt_ * n_.v + 0.25 * dt_ * dt_ * n_.a;
    now_.a = (force - spring * guess) / (structure_mass + 0.25 * dt_ * dt_ * spring);
    now_.d = guess + 0.25 * dt_ * dt_ * now_.a;
    now_.v = n_.v + 0.5 * dt_ * (n_.a + now_.a);
    out["displacement"] = across(now_.d - initial_displacement); // since Initialize
    out["velocity"] = across(now_.v);
    return IterationReport{1, 0, true};
  }
};

class Fluid : public Plate {
 public:
  explicit Fluid(Options o) : Plate(std::move(o), 7) { n_ = now_ = {0, 0, initial_acceleration}; }
  Description describe() override {
    Description d = described("oscillator fluid");
    d.pids = options_.pids;
    d.inputs = {field("mesh_displacement", C::DISPLACEMENT, C::MESH_NODES, 3),
                field("velocity", C::VELOCITY, C::INTERFACE_NODES, 3),
                field("velocity_start", C::VELOCITY, C::INTERFACE_NODES, 3)};
    d.outputs = {field("pressure", C::PRESSURE, C::INTERFACE_NODES, 1)};
    return d;
  }

 protected:
  Result<IterationReport> solve(const Fields& in, Fields& out) override {
    if (dt_ > options_.refuse_steps_above) return retryable_error("a step of {} is too long", dt_);
    if (refuses_) return retryable_error("not this time");
    const auto& v = in.at("velocity").values;
    n_.v = in.at("velocity_start").values[across_];
    FloatArray p{{nodes(), 1}, std::vector<double>(nodes())};
    for (std::size_t i = 0; i < nodes(); ++i)
      p.values[i] = -added_mass * (2 * (v[3 * i + across_] - n_.v) / dt_ - n_.a);
    now_.v = v[across_];
    now_.a = 2 * (now_.v - n_.v) / dt_ - n_.a;
    if (options_.mistake == "nan") p.values[3] = std::nan("");
    out["pressure"] = std::move(p);
    return IterationReport{1, 0, true};
  }
};

class Mover : public Plate {
 public:
  explicit Mover(Options o) : Plate(std::move(o), 7) {}
  Description describe() override {
    Description d = described("oscillator mesh mover");
    d.inputs = {field("displacement", C::DISPLACEMENT, C::INTERFACE_NODES, 3)};
    d.outputs = {field("mesh_displacement", C::DISPLACEMENT, C::MESH_NODES, 3)};
    return d;
  }

 protected:
  Result<IterationReport> solve(const Fields& in, Fields& out) override {
    FloatArray all = in.at("displacement");
    all.values.insert(all.values.begin(), 3 * more_nodes_, 0.0);
    all.shape[0] += more_nodes_;
    out["mesh_displacement"] = std::move(all);
    return IterationReport{1, 0, true};
  }
};

/// A process that does nothing, in the place of another MPI rank.
pid_t second_rank() {
  const pid_t pid = fork();
  if (pid == 0)
    while (true) pause();
  std::printf("second rank %d\n", pid);
  std::fflush(stdout);
  return pid;
}

} // namespace

int main(int argc, char** argv) {
  Options options;
  options.role = argc > 1 ? argv[1] : "";
  for (int i = 2; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--connect") options.endpoint = argv[i + 1];
    if (name == "--delay") options.delay = std::atof(argv[i + 1]);
    if (name == "--refuse-step") options.refused_step = std::strtoull(argv[i + 1], nullptr, 10);
    if (name == "--checkpoints") options.checkpoints = std::string(argv[i + 1]) == "yes";
    if (name == "--rolls-back") options.rolls_back = std::string(argv[i + 1]) == "yes";
    if (name == "--mistake") options.mistake = argv[i + 1];
    if (name == "--plane") options.plane = std::string(argv[i + 1]) == "yes";
    if (name == "--new-mesh") options.new_mesh_step = std::strtoull(argv[i + 1], nullptr, 10);
    if (name == "--replaces-mesh") options.replaces_mesh = std::string(argv[i + 1]) == "yes";
    if (name == "--velocity") options.velocity = std::atof(argv[i + 1]);
    if (name == "--fixed-residual") options.fixed_residual = std::atof(argv[i + 1]);
    if (name == "--refuse-steps-above") options.refuse_steps_above = std::atof(argv[i + 1]);
    if (name == "--fault") options.fault.kind = argv[i + 1];
    if (name == "--at") options.fault.at = argv[i + 1];
    if (name == "--second-rank") options.pids = {getpid(), second_rank()};
  }
  std::unique_ptr<Solver> solver;
  if (options.role == "structure") solver = std::make_unique<Structure>(options);
  if (options.role == "fluid") solver = std::make_unique<Fluid>(options);
  if (options.role == "mesh_mover") solver = std::make_unique<Mover>(options);
  if (!solver) return 2;
  const test::Fault fault = options.fault;
  if (!fault.at.empty()) solver = std::make_unique<test::FaultySolver>(std::move(solver), fault);
  const auto outcome = serve(*solver, serve_options_from_environment(options.endpoint));
  if (fault.at == "Shutdown") (void)fault.strike();
  if (fault.at == "destructor") std::abort();
  if (!outcome) std::fprintf(stderr, "%s\n", outcome.error().message.c_str());
  return outcome ? 0 : exit_status(outcome.error());
}
