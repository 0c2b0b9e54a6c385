// SPDX-License-Identifier: GPL-3.0-or-later
//
// The projection between two meshes of the unit hemisphere (an octahedron split n times and a grid of m
// rings) with 5,000, 20,000 and 80,000 nodes a side, in one process: set-up, and one coupling iteration,
// which takes a displacement to the fluid and its traction back to the structure as nodal forces. Beside each
// figure stands that of preCICE 3.4.1's nearest-projection mapping on the same pair, which includes its
// transport between two processes, and conserves no force that is also a good traction.
#include <benchmark/benchmark.h>

#include <malloc.h>
#include <unistd.h>

#include <fstream>

#include "coupler/launcher/process.hpp"
#include "tests/coupler/projection/surfaces.hpp"

namespace drogue::projection {
namespace {

struct Size {
  const char* name;
  int structure_splits, fluid_rings;
  const char *peer_set_up, *peer_iteration;
};
constexpr Size sizes[] = {{"5k", 50, 35, "0.05-0.09 s and 28 MB", "0.55-0.66 ms"},
                          {"20k", 100, 70, "0.21-0.24 s and 49 MB", "2.7-3.2 ms"},
                          {"80k", 200, 141, "0.83-0.99 s and 132 MB", "11.9-13.5 ms"}};

std::string beside(const char* peer, const std::string& own = "") {
  return own + "nearest projection of preCICE with transport: " + peer;
}

/// The kernel's highest mark of this process's memory starts again from what it holds now.
void restart_peak_memory() {
  malloc_trim(0);
  std::ofstream("/proc/self/clear_refs") << "5";
}

/// `recover_traction`: for a structure that takes tractions; one that takes forces, like ours, needs one mass
/// matrix less.
void set_up(benchmark::State& state, const Size& size, bool recover_traction) {
  const Surface structure = test::octahedron_hemisphere(size.structure_splits);
  const Surface fluid = test::lat_long_hemisphere(size.fluid_rings);
  restart_peak_memory();
  const double before = launcher::peak_memory_mb(getpid());
  for (auto _ : state)
    if (const auto made = make_interface(structure, fluid, {.recover_traction = recover_traction}); !made)
      state.SkipWithError(made.error().message.c_str());
  const double peak = launcher::peak_memory_mb(getpid()) - before;
  state.SetLabel(beside(size.peer_set_up, "peak " + std::to_string(static_cast<int>(peak)) + " MB; "));
}

/// The pair and the fields of an iteration.
struct Fields {
  explicit Fields(const Size& size)
      : interface(make_interface(test::octahedron_hemisphere(size.structure_splits),
                                 test::lat_long_hemisphere(size.fluid_rings), {})
                      .value()),
        d_s(test::sample(interface.structure, test::wavy)),
        d_f(interface.fluid.points.size()),
        t_f(test::sample(interface.fluid, test::wavy)),
        f_s(d_s.size()),
        t_s(d_s.size()) {}
  [[nodiscard]] bool displacement() { return interface.field.apply(d_s, d_f).ok(); }
  void force() {
    benchmark::DoNotOptimize(interface.load.from_traction({interface.fluid.points, {}}, t_f, f_s));
  }
  [[nodiscard]] bool traction() { return interface.load.recover_traction(f_s, t_s).ok(); }

  Interface interface;
  std::vector<double> d_s, d_f, t_f, f_s, t_s;
};

void displacement(benchmark::State& state, const Size& size) {
  Fields fields(size);
  for (auto _ : state)
    if (!fields.displacement()) state.SkipWithError("no solution");
}

void nodal_force(benchmark::State& state, const Size& size) {
  Fields fields(size);
  for (auto _ : state) fields.force();
}

void recovered_traction(benchmark::State& state, const Size& size) {
  Fields fields(size);
  fields.force();
  for (auto _ : state)
    if (!fields.traction()) state.SkipWithError("no solution");
}

void iteration(benchmark::State& state, const Size& size) {
  Fields fields(size);
  for (auto _ : state) {
    if (!fields.displacement()) state.SkipWithError("no solution");
    fields.force();
  }
  state.SetLabel(beside(size.peer_iteration));
}

const bool registered = [] {
  for (const Size& size : sizes) {
    const auto add = [&](const char* what, auto function) {
      benchmark::RegisterBenchmark((std::string(what) + "/" + size.name).c_str(), function, size)
          ->Unit(benchmark::kMillisecond);
    };
    add("set_up", [](benchmark::State& state, const Size& s) { set_up(state, s, false); });
    add("set_up_with_traction", [](benchmark::State& state, const Size& s) { set_up(state, s, true); });
    add("iteration", iteration);
    add("displacement", displacement);
    add("nodal_force", nodal_force);
    add("recovered_traction", recovered_traction);
  }
  return true;
}();

} // namespace
} // namespace drogue::projection
