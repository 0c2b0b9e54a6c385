// SPDX-License-Identifier: GPL-3.0-or-later
//
// The mesh motion around the inflated T-10, on meshes from some 20,000 to 500,000 nodes; the one with the
// canopy of the paper's compatible mesh has the paper's size. Measured on each: the making of the mesh,
// set-up, the preparation of a step (assembly and preconditioner), one solve to 1e-6 of a step's increment
// from a start value of zero, its iterations, memory, and the exponent of growth of the solve. On the paper's
// size also a whole motion: the canopy inflates by 10 % of its diameter, shrinks by as much below its first
// shape, and moves half a diameter to the side. Prints rows as Google Benchmark's csv does:
// name,iterations,value,value,unit.
//   mesh_t10_bench [--paper-only] [ignored options...]
#include <cmath>
#include <cstring>
#include <ctime>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "benchmarks/support/measure.hpp"
#include "common/la_direct/direct_solver.hpp"
#include "mesh_mover/mover.hpp"
#include "tests/support/t10_fluid.hpp"

namespace drogue::mesh_mover {
namespace {

using namespace bench;

const double diameter = test::t10_canopy.diameter; // ft

/// Processor time of this process, all threads.
double processor_seconds() {
  return static_cast<double>(std::clock()) / CLOCKS_PER_SEC;
}

Boundary side(const char* name) {
  Boundary boundary;
  boundary.name = name;
  return boundary;
}

Boundary canopy(const char* name) {
  Boundary boundary;
  boundary.name = name;
  boundary.condition = Condition::displacement;
  boundary.is_interface = true;
  return boundary;
}

Settings settings_with(double tolerance) {
  Settings settings;
  settings.boundaries = {canopy("canopy_upper"), canopy("canopy_lower"), side("inflow"), side("outflow"),
                         side("side")};
  settings.tolerance = tolerance;
  return settings;
}

/// The canopy scaled by 1 + `growth` across its axis and moved by `shift` in x.
std::vector<double> canopy_displacement(const MeshMover& mover, double growth, double shift) {
  std::vector<double> d;
  for (const std::int32_t node : mover.motion().interface_nodes()) {
    const double* X = &mover.mesh().points[3 * static_cast<std::size_t>(node)];
    d.insert(d.end(), {growth * X[0] + shift, growth * X[1], 0});
  }
  return d;
}

struct Cost {
  double nodes = 0, solve = 0, memory = 0;
};

Result<SolveReport> step(MeshMover& mover, double growth, double shift, double& preparation,
                         double& solution) {
  Result<void> begun = {};
  preparation = seconds([&] { begun = mover.begin_step(1); });
  if (!begun) return begun.error();
  const auto d = canopy_displacement(mover, growth, shift);
  BoundaryInput input;
  input.interface_displacement = d;
  Result<SolveReport> report = SolveReport{};
  solution = seconds([&] { report = mover.solve(input); });
  return report;
}

Cost one_solve(const mesh::Mesh& mesh, const std::string& name) {
  const double before = resident_megabytes();
  Result<std::unique_ptr<MeshMover>> made = internal_error("not made");
  const double setup = seconds([&] { made = MeshMover::create(mesh, settings_with(1e-6)); });
  if (!require(made.ok(), "no mover")) return {};
  MeshMover& mover = **made;
  double preparation = 0, solution = 0;
  const double processor = processor_seconds();
  const auto report = step(mover, 0.01, 0.01 * diameter, preparation, solution);
  const double processor_time = processor_seconds() - processor;
  if (!require(report.ok(), report ? "" : report.error().message)) return {};
  const Cost cost{static_cast<double>(mesh.node_count()), solution, resident_megabytes() - before};
  row(name + "/nodes", cost.nodes, "count");
  row(name + "/tetrahedra", static_cast<double>(mover.cells().count()), "count");
  row(name + "/setup", setup, "s");
  row(name + "/preparation_of_a_step", preparation, "s");
  row(name + "/solve_to_1e-6", solution, "s");
  row(name + "/step_processor_time", processor_time, "s");
  row(name + "/iterations", report->iterations, "count");
  row(name + "/memory", cost.memory, "MB");
  return cost;
}

/// Diameter + 10 %, - 10 %, back, and half a diameter to the side, in steps of 2 % of the diameter.
void large_motion(const mesh::Mesh& mesh, const std::string& name) {
  auto made = MeshMover::create(mesh, settings_with(1e-4));
  if (!require(made.ok(), "no mover")) return;
  MeshMover& mover = **made;
  std::vector<std::array<double, 2>> path; // growth of the diameter, shift in diameters
  for (int k = 1; k <= 5; ++k) path.push_back({0.02 * k, 0});
  for (int k = 1; k <= 10; ++k) path.push_back({0.1 - 0.02 * k, 0});
  for (int k = 1; k <= 5; ++k) path.push_back({-0.1 + 0.02 * k, 0});
  for (int k = 1; k <= 25; ++k) path.push_back({0, 0.02 * k});
  double preparations = 0, solutions = 0, smallest = 1, angle = 90;
  int iterations = 0;
  for (const auto& [growth, shift] : path) {
    double preparation = 0, solution = 0;
    const auto report = step(mover, growth, shift * diameter, preparation, solution);
    if (!require(report.ok(), report ? "" : report.error().message)) return;
    mover.commit();
    preparations += preparation;
    solutions += solution;
    iterations += report->iterations;
    smallest = std::min(smallest, report->quality.min_volume_ratio);
    angle = std::min(angle, report->quality.smallest_angle);
  }
  const auto n = static_cast<double>(path.size());
  row(name + "/large_motion/steps", n, "count");
  row(name + "/large_motion/preparation_of_a_step", preparations / n, "s");
  row(name + "/large_motion/solve_to_1e-4", solutions / n, "s");
  row(name + "/large_motion/iterations", iterations / n, "count");
  row(name + "/large_motion/smallest_volume_ratio", 100 * smallest, "percent");
  row(name + "/large_motion/smallest_angle_in_degrees", angle, "count");
}

} // namespace
} // namespace drogue::mesh_mover

int main(int argc, char** argv) {
  using namespace drogue;
  using namespace mesh_mover;
  spdlog::set_level(spdlog::level::warn);
  la::use_one_blas_thread();
  bool paper_only = false;
  for (int i = 1; i < argc; ++i) paper_only = paper_only || std::strcmp(argv[i], "--paper-only") == 0;
  Cost first, last;
  for (const test::T10FluidSize* size :
       {&test::t10_fluid_small, &test::t10_fluid_middle, &test::t10_fluid_paper, &test::t10_fluid_large}) {
    const bool paper = size == &test::t10_fluid_paper;
    if (paper_only && !paper) continue;
    const std::string name = std::string("t10_") + size->name;
    const double processor = processor_seconds();
    Result<mesh::Mesh> mesh = internal_error("not made");
    const double meshing = bench::seconds([&] { mesh = test::t10_fluid_mesh(*size); });
    if (!require(mesh.ok(), mesh ? "" : mesh.error().message)) return 1;
    bench::row(name + "/meshing", meshing, "s");
    bench::row(name + "/meshing_processor_time", processor_seconds() - processor, "s");
    last = one_solve(*mesh, name);
    if (first.nodes == 0) first = last;
    if (paper) large_motion(*mesh, name);
  }
  if (last.nodes > first.nodes)
    row("t10/solve_growth", std::log(last.solve / first.solve) / std::log(last.nodes / first.nodes),
        "exponent");
  return 0;
}
