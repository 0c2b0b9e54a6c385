// SPDX-License-Identifier: GPL-3.0-or-later
//
// `coupler run` between processes of their own over ZeroMQ, on the hemisphere pair of projection_bench.cpp: a
// structure and a fluid that only hand over stored fields, and a mesh mover that passes on what it gets; 20
// steps of 10 forced iterations. From the structure's clock: set-up (from the last interface mesh handed over
// to the first step), an iteration, and the coupler's peak memory. An iteration is more than what preCICE
// 3.4.1's nearest projection does in the times beside it: displacement and velocity are projected, the mesh
// motion passes through the coupler, and force, moment, work and the defects of both projections are
// accounted for. With --answer ROLE it is one of the participants.
#include <cstdlib>
#include <ctime>
#include <map>
#include <sstream>

#include <spdlog/spdlog.h>

#include "benchmarks/support/measure.hpp"
#include "coupler/launcher/process.hpp"
#include "participant/cpp/participant.hpp"
#include "tests/coupler/projection/surfaces.hpp"

namespace drogue {
namespace {

namespace fs = std::filesystem;
using namespace bench;
using namespace participant;
using C = v1::FieldContract;

constexpr int steps = 20, iterations = 10;

/// Of all processes of the machine.
double now() {
  timespec t{};
  clock_gettime(CLOCK_MONOTONIC, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Hands over the same fields in each iteration, and notes the time of the first and the last in times.csv.
class Stored : public Solver {
 public:
  Stored(std::string role, const projection::Surface& surface) : role_(std::move(role)) {
    mesh_.points = surface.reference;
    for (const auto& block : surface.blocks)
      mesh_.triangles.insert(mesh_.triangles.end(), block.nodes.begin(), block.nodes.end());
    const std::uint64_t n = mesh_.mesh_node_count = mesh_.points.size() / 3;
    for (std::uint64_t i = 0; i < n; ++i) mesh_.mesh_nodes.push_back(static_cast<std::int64_t>(i));
    field_ = {{n, 3}, projection::test::sample(surface, projection::test::wavy)};
  }
  Description describe() override {
    Description d;
    d.software = "stored fields";
    const auto on_interface = [](const char* name, C::Quantity quantity) {
      return participant::field(name, quantity, C::INTERFACE_NODES, 3);
    };
    const auto mesh_displacement = participant::field("mesh_displacement", C::DISPLACEMENT, C::MESH_NODES, 3);
    if (role_ == "structure") {
      d.inputs = {on_interface("force", C::FORCE)};
      d.outputs = {on_interface("displacement", C::DISPLACEMENT), on_interface("velocity", C::VELOCITY)};
    } else if (role_ == "fluid") {
      d.inputs = {mesh_displacement, on_interface("velocity", C::VELOCITY)};
      d.outputs = {on_interface("traction", C::TRACTION)};
    } else {
      d.inputs = {on_interface("displacement", C::DISPLACEMENT)};
      d.outputs = {mesh_displacement};
    }
    return d;
  }
  Result<void> configure(const RunInfo& run) override {
    directory_ = run.directory;
    return {};
  }
  Result<InterfaceMesh> initialize() override {
    ready_ = now();
    return mesh_;
  }
  Result<void> begin_step(const StepInfo&) override {
    if (first_ == 0) first_ = now();
    return {};
  }
  Result<IterationReport> iterate(const Fields& in, Fields& out) override {
    if (role_ == "mesh_mover") out["mesh_displacement"] = in.at("displacement");
    if (role_ == "fluid") out["traction"] = field_;
    if (role_ == "structure") out["displacement"] = out["velocity"] = field_;
    if (++count_ == 1) first_iterate_ = now();
    last_iterate_ = now();
    return IterationReport{};
  }
  Result<void> commit(bool) override { return {}; }
  Result<void> rollback() override { return {}; }
  Result<void> checkpoint(const fs::path&) override { return {}; }
  Result<void> restore(const fs::path&) override { return {}; }
  void write_times() const {
    std::ofstream(directory_ / "times")
        << fmt::format("{} {} {} {} {}\n", ready_, first_, first_iterate_, last_iterate_, count_);
  }

 private:
  std::string role_;
  InterfaceMesh mesh_;
  FloatArray field_;
  fs::path directory_;
  double ready_ = 0, first_ = 0, first_iterate_ = 0, last_iterate_ = 0;
  int count_ = 0;
};

struct Times {
  double ready = 0, first = 0, first_iterate = 0, last_iterate = 0;
  int count = 0;
};

Times read_times(const fs::path& directory) {
  Times t;
  std::ifstream(directory / "times") >> t.ready >> t.first >> t.first_iterate >> t.last_iterate >> t.count;
  return t;
}

struct Size {
  const char* name;
  int structure_splits, fluid_rings;
};
constexpr Size sizes[] = {{"5k", 50, 35}, {"20k", 100, 70}, {"80k", 200, 141}};

int answer(const std::string& role, const std::string& size, const std::string& endpoint) {
  for (const Size& s : sizes) {
    if (size != s.name) continue;
    projection::Surface surface = role == "structure"
                                      ? projection::test::octahedron_hemisphere(s.structure_splits)
                                      : projection::test::lat_long_hemisphere(s.fluid_rings);
    if (!projection::complete(surface)) return 1;
    Stored solver(role, surface);
    const bool ok = serve(solver, serve_options_from_environment(endpoint)).ok();
    solver.write_times();
    return ok ? 0 : 1;
  }
  return 2;
}

void write_case(const fs::path& folder, const Size& size) {
  const std::string self = fs::read_symlink("/proc/self/exe").string();
  const auto participant = [&](const char* role) {
    return fmt::format("{0} {{ command: '{1}' argument: '--answer' argument: '{0}' argument: '{2}' }}\n",
                       role, self, size.name);
  };
  std::ofstream(folder / "case.textproto")
      << fmt::format("name: 'stored fields' run_directory: 'run'\n{}{}{}"
                     "time {{ step: 1 steps: {} }}\n"
                     "loop {{ min_iterations: {} max_iterations: {} non_convergence: ACCEPT stall: 0 }}\n"
                     "acceleration {{ method: CONSTANT relaxation: 1 }}\n"
                     "outer_boundary: FIXED\n",
                     participant("structure"), participant("mesh_mover"), participant("fluid"), steps,
                     iterations, iterations);
}

/// The number before " MB" behind `name` in what the coupler says at the end.
double peak_memory(const fs::path& output, const std::string& name) {
  std::ostringstream text;
  text << std::ifstream(output).rdbuf();
  const std::string all = text.str();
  const auto line = all.rfind("peak memory: ");
  const auto at = line == std::string::npos ? line : all.find(name + " ", line);
  return at == std::string::npos ? 0 : std::atof(all.c_str() + at + name.size() + 1);
}

void measure(const Size& size) {
  std::string folder = (fs::temp_directory_path() / "drogue-bench-XXXXXX").string();
  if (!mkdtemp(folder.data())) return;
  write_case(folder, size);
  const fs::path output = fs::path(folder) / "output.txt";
  auto coupler = launcher::Process::start(
      {{std::string(DROGUE_BIN_DIR) + "/coupler", "run", "case.textproto"}, {}, folder, output});
  const bool ran = coupler.ok() && [&] {
    const auto& exit = coupler->wait(std::chrono::minutes(10));
    return exit.has_value() && exit->clean();
  }();
  if (require(ran, "the coupled run failed: " + output.string())) {
    const fs::path run = fs::path(folder) / "run";
    const Times structure = read_times(run / "structure");
    double ready = structure.ready;
    for (const char* role : {"fluid", "mesh_mover"}) ready = std::max(ready, read_times(run / role).ready);
    if (require(structure.count == steps * iterations, "not the iterations that were asked for")) {
      const std::string name = std::string("exchange/") + size.name;
      row(name + "/set_up", structure.first - ready, "s");
      row(name + "/iteration", structure.count,
          1e3 * (structure.last_iterate - structure.first_iterate) / (structure.count - 1), "ms");
      row(name + "/peak_memory_of_the_coupler", peak_memory(output, "coupler"), "MB");
    }
    fs::remove_all(folder);
  }
}

} // namespace
} // namespace drogue

int main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::warn);
  if (argc >= 4 && std::string(argv[1]) == "--answer") {
    const std::string endpoint = argc > 5 ? argv[5] : "";
    return drogue::answer(argv[2], argv[3], endpoint);
  }
  for (const drogue::Size& size : drogue::sizes) drogue::measure(size);
  return 0;
}
