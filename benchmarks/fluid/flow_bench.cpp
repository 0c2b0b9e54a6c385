// SPDX-License-Identifier: GPL-3.0-or-later
//
// The flow round the inflated T-10 at the paper's size: kernels beside the limits of the machine, whole steps
// on one rank and two, growth with the mesh. Prints rows as Google Benchmark's csv does. Starts itself again
// under mpiexec for two ranks.
//   fluid_flow_bench [--quick] [ignored options...]
#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>

#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <unistd.h>

#include "benchmarks/fluid/kernels.hpp"
#include "benchmarks/fluid/machine.hpp"
#include "benchmarks/support/measure.hpp"
#include "common/la_krylov/session.hpp"
#include "common/mesh/msh.hpp"
#include "fluid_solver/flow_solver.hpp"
#include "fluid_solver/forces.hpp"
#include "tests/support/t10_fluid.hpp"

namespace drogue::bench {
namespace {

using namespace fluid;

/// Sea-level air at 22 ft/s (feet, slugs, seconds), as in configs/t10.
Settings t10_flow() {
  Settings s;
  s.density = 0.002377;
  s.dynamic_viscosity = 3.66058e-7;
  s.smagorinsky = 0.1;
  s.initial_velocity[2] = config::Expression::parse("22").value();
  s.newton = {1e-12, 3, 10, 1, 1000};
  s.linear_method = LinearMethod::krylov;
  s.linear = {1e-2, 300, 60};
  s.boundaries.resize(5);
  const Condition conditions[] = {Condition::velocity, Condition::traction_free, Condition::free_slip,
                                  Condition::no_slip, Condition::no_slip};
  const char* names[] = {"inflow", "outflow", "side", "canopy_upper", "canopy_lower"};
  for (std::size_t i = 0; i < 5; ++i) {
    s.boundaries[i].name = names[i];
    s.boundaries[i].condition = conditions[i];
  }
  s.boundaries[0].value[2] = s.initial_velocity[2];
  s.boundaries[1].backflow = 0.5;
  s.forces = {{"canopy", {"canopy_upper", "canopy_lower"}, 0.5 * s.density * 22 * 22 * 1298.9, {}}};
  return s;
}

struct Steps {
  double time = 0; ///< mean of a step [s], the first left out
  double iterations = 0;
  double force = 0; ///< on the canopy along the flow after the last step
};

/// Steps with the whole mesh swaying, three Newton iterations each.
Steps run_steps(const Settings& settings, const FluidMesh& mesh, Formulation formulation, int count) {
  FlowSolver solver(settings, mesh);
  Steps steps;
  const double dt = 0.0032;
  for (int k = 0; k <= count; ++k) {
    int iterations = 0;
    const double time = seconds([&] {
      if (!solver.begin_step({formulation}, dt)) std::abort();
      std::vector<double> x = mesh.points;
      std::vector<double> rest(x.size(), 0.0);
      if (formulation == Formulation::dsd_sst)
        for (std::size_t i = 2; i < x.size(); i += 3) x[i] += 1e-3 * std::sin(40 * dt * (k + 1));
      if (!solver.set_end(x, rest, rest)) std::abort();
      const auto report = solver.newton(3);
      if (!report || !solver.finish()) std::abort();
      iterations = report->linear_iterations;
      steps.force = surface_forces(settings, mesh, solver)[0].total()[2];
      solver.commit();
    });
    if (k == 0) continue;
    steps.time += time / count;
    steps.iterations += static_cast<double>(iterations) / count;
  }
  return steps;
}

/// On every rank; rank 0 prints.
void step_rows(const FluidMesh& mesh, const std::string& name, Formulation formulation, bool tight) {
  const Settings settings = t10_flow();
  const Steps steps = run_steps(settings, mesh, formulation, 4);
  const double memory = la::sum_over_ranks(peak_megabytes());
  double error = 0;
  if (tight) {
    Settings exact = settings;
    exact.linear.tolerance = 1e-7;
    exact.newton.max_iterations = 6;
    const double force = run_steps(exact, mesh, formulation, 4).force;
    error = std::abs(steps.force - force) / std::abs(force);
  }
  if (la::rank() != 0) return;
  row(name + "/step", steps.time, "s");
  row(name + "/gmres_iterations_a_step", steps.iterations, "count");
  row(name + "/microseconds_a_node", 1e6 * steps.time / mesh.node_count(), "us");
  row(name + "/memory", memory, "MB");
  if (tight) row(name + "/canopy_force_error", 100 * error, "percent");
}

FluidMesh load(const std::filesystem::path& file) {
  auto read = mesh::read_msh(file);
  if (!read) fmt::print(stderr, "fluid_flow_bench: {}\n", read.error().message), std::exit(1);
  auto made = FluidMesh::create(std::move(*read));
  if (!made) fmt::print(stderr, "fluid_flow_bench: {}\n", made.error().message), std::exit(1);
  return std::move(*made);
}

/// Makes the mesh and leaves it in a file.
void make(const test::T10FluidSize& size, const std::filesystem::path& file) {
  const double time = seconds([&] {
    const auto mesh = test::t10_fluid_mesh(size);
    if (!mesh || !mesh::write_msh(file, *mesh)) {
      fmt::print(stderr, "fluid_flow_bench: no mesh: {}\n", mesh ? file.string() : mesh.error().message);
      std::exit(1);
    }
  });
  row(fmt::format("mesh_{}/time", size.name), time, "s");
}

/// What each rank of a child does.
void on_ranks(const std::string& file, const std::string& name, bool space_time) {
  const FluidMesh mesh = load(file);
  const int ranks = la::rank_count();
  step_rows(mesh,
            fmt::format("{}_{}_{}_rank{}", space_time ? "dsd_sst" : "semi_discrete", name, ranks,
                        ranks > 1 ? "s" : ""),
            space_time ? Formulation::dsd_sst : Formulation::semi_discrete, space_time && ranks == 1);
}

/// A child, so that its peak of memory is its own; and a process that has started MPI could not call mpiexec.
void run_steps_on(int ranks, const char* self, const std::string& file, const std::string& name,
                  bool space_time) {
  std::fflush(stdout);
  const std::string launch = ranks == 1 ? "" : fmt::format("mpiexec --oversubscribe -n {} ", ranks);
  const std::string command = fmt::format("{}'{}' --ranks '{}' '{}' {}", launch, self, file, name,
                                          space_time ? "space_time" : "semi_discrete");
  if (std::system(command.c_str()) != 0) fmt::print(stderr, "fluid_flow_bench: failed: {}\n", command);
}

void all(const char* self, bool quick) {
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("drogue-flow-bench-{}", getpid());
  std::filesystem::create_directories(folder);
  row("memory_bandwidth", memory_bandwidth() / 1e6, "MB");
  row("arithmetic_peak", arithmetic_peak() / 1e6, "count");
  for (const auto& size : {test::t10_fluid_small, test::t10_fluid_paper, test::t10_fluid_large}) {
    const std::string file = folder / fmt::format("{}.msh", size.name);
    if (quick && size.name != test::t10_fluid_small.name) break;
    make(size, file);
    const FluidMesh mesh = load(file);
    row(fmt::format("mesh_{}/nodes", size.name), mesh.node_count(), "count");
    row(fmt::format("mesh_{}/tetrahedra", size.name), mesh.cell_count(), "count");
    const bool large = size.name == test::t10_fluid_large.name;
    kernel_rows<4>(mesh, fmt::format("semi_discrete_{}", size.name));
    if (!large) kernel_rows<8>(mesh, fmt::format("dsd_sst_{}", size.name));
    for (const bool space_time : {true, false})
      for (const int ranks : {1, 2})
        if (!large || (ranks == 1 && !space_time)) run_steps_on(ranks, self, file, size.name, space_time);
  }
  std::filesystem::remove_all(folder);
}

} // namespace
} // namespace drogue::bench

int main(int argc, char** argv) {
  spdlog::set_level(spdlog::level::warn);
  if (argc == 5 && std::strcmp(argv[1], "--ranks") == 0) {
    const auto session = drogue::la::Session::start();
    if (!session) return 1;
    drogue::bench::on_ranks(argv[2], argv[3], std::strcmp(argv[4], "space_time") == 0);
    return 0;
  }
  drogue::bench::all(argv[0], argc > 1 && std::strcmp(argv[1], "--quick") == 0);
  return 0;
}
