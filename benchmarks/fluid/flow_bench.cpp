// SPDX-License-Identifier: GPL-3.0-or-later
//
// The flow round the inflated T-10 at the paper's size: kernels beside the limits of the machine, whole steps
// on one rank and two, growth with the mesh, the Jacobian beside that of dolfinx. Prints rows as Google
// Benchmark's csv does. Starts itself again, under mpiexec for two ranks.
//   fluid_flow_bench [--quick] [ignored options...]
//   fluid_flow_bench --kernels MESH     the kernels alone, on a mesh from a file
#include <array>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <optional>
#include <vector>

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
  double time = 0;      ///< mean of a step [s], the first left out
  double processor = 0; ///< the same of this rank's processor time
  double iterations = 0;
  double memory = 0; ///< of all ranks, with the solver alive; a page that they share counts once [MB]
  double force = 0;  ///< on the canopy along the flow after the last step
};

/// Steps with the whole mesh swaying, three Newton iterations each.
Steps run_steps(const Settings& settings, const FluidMesh& mesh, Formulation formulation, int count) {
  FlowSolver solver(settings, mesh);
  Steps steps;
  const double dt = 0.0032;
  for (int k = 0; k <= count; ++k) {
    int iterations = 0;
    const double processor = processor_seconds();
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
    steps.processor += (processor_seconds() - processor) / count;
    steps.iterations += static_cast<double>(iterations) / count;
  }
  steps.memory = la::sum_over_ranks(proportional_megabytes());
  return steps;
}

/// On every rank; rank 0 prints.
void step_rows(const FluidMesh& mesh, const std::string& name, Formulation formulation, bool tight) {
  const Settings settings = t10_flow();
  const Steps steps = run_steps(settings, mesh, formulation, 4);
  const double peaks = la::sum_over_ranks(peak_megabytes());
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
  row(name + "/processor_time_of_rank_0", steps.processor, "s");
  row(name + "/gmres_iterations_a_step", steps.iterations, "count");
  row(name + "/microseconds_a_node", 1e6 * steps.time / mesh.node_count(), "us");
  row(name + "/memory", steps.memory, "MB");
  row(name + "/sum_of_peaks", peaks, "MB"); // what the ranks share counts for each
  row(name + "/kilobytes_a_node", 1e3 * steps.memory / mesh.node_count(), "count");
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

/// Runs a command and passes its rows on; the value of the one whose name ends in `wanted`.
std::optional<double> rows_of(const std::string& command, const std::string& wanted) {
  std::fflush(stdout);
  std::FILE* out = ::popen(command.c_str(), "r");
  std::optional<double> value;
  char line[400];
  while (out != nullptr && std::fgets(line, sizeof line, out) != nullptr) {
    std::fputs(line, stdout);
    double first = 0;
    if (const char* end = std::strstr(line, (wanted + "\",").c_str()); end != nullptr)
      if (std::sscanf(end + wanted.size() + 2, "%*d,%lf", &first) == 1) value = first;
  }
  std::fflush(stdout);
  if (out == nullptr || ::pclose(out) != 0) fmt::print(stderr, "fluid_flow_bench: failed: {}\n", command);
  return value;
}

/// A child, so that its peak of memory is its own; and a process that has started MPI could not call mpiexec.
/// Returns the processor time of a step on rank 0.
std::optional<double> run_steps_on(int ranks, const char* self, const std::string& file,
                                   const std::string& name, bool space_time) {
  const std::string launch = ranks == 1 ? "" : fmt::format("mpiexec --oversubscribe -n {} ", ranks);
  return rows_of(fmt::format("{}'{}' --ranks '{}' '{}' {}", launch, self, file, name,
                             space_time ? "space_time" : "semi_discrete"),
                 "/processor_time_of_rank_0");
}

template <class T>
void write_raw(const std::string& file, const std::vector<T>& values) {
  std::ofstream out(file, std::ios::binary);
  out.write(reinterpret_cast<const char*>(values.data()),
            static_cast<std::streamsize>(sizeof(T) * values.size()));
}

/// The same Jacobian by a general form compiler, where it is installed.
void dolfinx_rows(const FluidMesh& mesh, const std::string& file, const std::string& name, double ours) {
  write_raw(file + ".points", mesh.points);
  write_raw(file + ".cells", mesh.cells);
  std::fflush(stdout);
  const auto command =
      fmt::format(DROGUE_PYTHON " '" DROGUE_DOLFINX_SCRIPT "' '{0}.points' '{0}.cells'", file);
  std::FILE* out = ::popen(command.c_str(), "r");
  double theirs = 0;
  const bool read = out != nullptr && std::fscanf(out, "%lf", &theirs) == 1;
  if (out != nullptr) ::pclose(out);
  row(name + "/dolfinx_is_installed", read ? 1 : 0, "count");
  if (!read) return;
  row(name + "/jacobian_assembly_of_dolfinx", 1e3 * theirs, "ms");
  row(name + "/dolfinx_over_ours", theirs / ours, "count");
}

/// How the time of a step on one rank grows with the mesh: exponents from each size to the next.
class Growth {
 public:
  explicit Growth(std::string name) : name_(std::move(name)) {}
  void add(const std::string& size, std::int32_t nodes, std::optional<double> time) {
    if (!time) return;
    if (last_time_ > 0)
      row(fmt::format("{}/growth_to_{}", name_, size),
          std::log(*time / last_time_) / std::log(nodes / last_nodes_), "exponent");
    last_nodes_ = nodes;
    last_time_ = *time;
  }

 private:
  std::string name_;
  double last_nodes_ = 0;
  double last_time_ = 0;
};

void all(const char* self, bool quick) {
  const auto folder = std::filesystem::temp_directory_path() / fmt::format("drogue-flow-bench-{}", getpid());
  std::filesystem::create_directories(folder);
  row("memory_bandwidth", memory_bandwidth() / 1e6, "MB");
  row("arithmetic_peak", arithmetic_peak() / 1e6, "count");
  Growth semi_discrete("semi_discrete"), dsd_sst("dsd_sst");
  for (const auto& size : {test::t10_fluid_smallest, test::t10_fluid_paper, test::t10_fluid_large}) {
    const std::string file = folder / fmt::format("{}.msh", size.name);
    if (quick && size.name != test::t10_fluid_smallest.name) break;
    make(size, file);
    std::int32_t nodes = 0;
    const bool large = size.name == test::t10_fluid_large.name;
    { // freed before the steps
      const FluidMesh mesh = load(file);
      nodes = mesh.node_count();
      row(fmt::format("mesh_{}/nodes", size.name), nodes, "count");
      row(fmt::format("mesh_{}/tetrahedra", size.name), mesh.cell_count(), "count");
      const std::string name = fmt::format("semi_discrete_{}", size.name);
      const double jacobian = kernel_rows<4>(mesh, name);
      if (!large) dolfinx_rows(mesh, file, name, jacobian);
      if (!large) kernel_rows<8>(mesh, fmt::format("dsd_sst_{}", size.name));
    }
    if (!large) dsd_sst.add(size.name, nodes, run_steps_on(1, self, file, size.name, true));
    if (!large) (void)run_steps_on(2, self, file, size.name, true);
    semi_discrete.add(size.name, nodes, run_steps_on(1, self, file, size.name, false));
    if (!large) (void)run_steps_on(2, self, file, size.name, false);
  }
  std::filesystem::remove_all(folder);
}

void kernels_on(const std::string& file) {
  const FluidMesh mesh = load(file);
  row("memory_bandwidth", memory_bandwidth() / 1e6, "MB");
  row("arithmetic_peak", arithmetic_peak() / 1e6, "count");
  (void)kernel_rows<4>(mesh, "semi_discrete");
  (void)kernel_rows<8>(mesh, "dsd_sst");
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
  if (argc == 3 && std::strcmp(argv[1], "--kernels") == 0) {
    drogue::bench::kernels_on(argv[2]);
    return 0;
  }
  drogue::bench::all(argv[0], argc > 1 && std::strcmp(argv[1], "--quick") == 0);
  return 0;
}
