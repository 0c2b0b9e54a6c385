// SPDX-License-Identifier: GPL-3.0-or-later
//
// The structure at the paper's size: parts of a Newton iteration on the T-10's two meshes and on meshes with
// 4 and 16 times the elements, memory, exponents of growth with the number of equations, and whole static
// inflations. Prints rows as Google Benchmark's csv does: name,iterations,value,value,unit. Times are the
// least of several runs.
//   structure_t10_bench [--no-inflation] [ignored options...]
#include <algorithm>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <string>

#include <unistd.h>

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "benchmarks/support/measure.hpp"
#include "common/la_direct/direct_solver.hpp"
#include "structure_solver/run.hpp"
#include "tests/support/t10_structure.hpp"

namespace drogue::structure {
namespace {

using namespace bench;

struct Iteration {
  double equations = 0, time = 0, memory = 0;
};

/// A state of the inflation some steps after the start, and then the parts of an iteration there.
Iteration newton_iteration(bool compatible, int refine, const std::string& name) {
  const double before = resident_megabytes();
  config::Report report;
  const Case c = test::t10_inflation(compatible, refine, 2.5e-3, report);
  if (!require(c.model != nullptr, "no model")) return {};
  Integrator integrator(*c.model, c.integrator_options(), c.start);
  for (int k = 0; k < 3; ++k) {
    integrator.begin_step(0.005 / refine, Integrator::Predictor::hold);
    const auto outcome = integrator.iterate(8);
    if (!require(outcome.ok(), "Newton failed")) return {};
    integrator.commit();
  }
  integrator.begin_step(0.005 / refine, Integrator::Predictor::hold);

  const int runs = refine == 1 ? 30 : 5;
  std::vector<double> r(c.model->equation_count()), correction(r.size());
  la::CholeskySolver cholesky;
  Iteration it{static_cast<double>(r.size()), 0, resident_megabytes() - before};
  const double residual = least(runs, [&] { integrator.residual(r, false); });
  const double assembly = least(runs, [&] { integrator.residual(r, true); });
  bool ok = true;
  const auto factor = [&] {
    const auto factored = cholesky.factor(integrator.tangent());
    ok = ok && factored.ok() && *factored;
  };
  const double analysis_and_factor = seconds(factor);
  const double factorisation = least(runs, factor);
  const double solve = least(runs, [&] { ok = cholesky.solve(r, correction).ok() && ok; });
  if (!require(ok, "CHOLMOD failed")) return {};
  it.time = assembly + factorisation + solve;
  row(name + "/equations", 1, it.equations, "count");
  row(name + "/residual", runs, 1e3 * residual, "ms");
  row(name + "/assembly", runs, 1e3 * assembly, "ms");
  row(name + "/analysis", 1, 1e3 * (analysis_and_factor - factorisation), "ms");
  row(name + "/factorisation", runs, 1e3 * factorisation, "ms");
  row(name + "/solve", runs, 1e3 * solve, "ms");
  row(name + "/newton_iteration", runs, 1e3 * it.time, "ms");
  row(name + "/assembly_share", runs, 100 * assembly / it.time, "percent");
  row(name + "/memory", 1, it.memory, "MB");
  return it;
}

void growth(bool compatible, const std::string& name) {
  Iteration last = newton_iteration(compatible, 1, name);
  for (const int refine : {2, 4}) {
    const Iteration now = newton_iteration(compatible, refine, fmt::format("{}_x{}", name, refine * refine));
    const double size = std::log(now.equations / last.equations);
    row(fmt::format("{}_x{}/time_exponent", name, refine * refine), 1, std::log(now.time / last.time) / size,
        "exponent");
    row(fmt::format("{}_x{}/memory_exponent", name, refine * refine), 1,
        std::log(now.memory / last.memory) / size, "exponent");
    last = now;
  }
}

void inflation(bool compatible, const std::string& name) {
  config::Report report;
  Case c = test::t10_inflation(compatible, 1, 2.5e-3, report);
  if (!require(c.model != nullptr, "no model")) return;
  c.settings.output.directory =
      std::filesystem::temp_directory_path() / ("drogue-t10-bench-" + std::to_string(getpid()));
  bool ok = false;
  const double time = seconds([&] { ok = run(c).ok(); });
  std::filesystem::remove_all(c.settings.output.directory);
  if (require(ok, "the inflation failed")) row(name + "/static_inflation", 1, time, "s");
}

} // namespace
} // namespace drogue::structure

int main(int argc, char** argv) {
  using namespace drogue;
  using namespace structure;
  spdlog::set_level(spdlog::level::warn);
  la::use_one_blas_thread();
  bool with_inflation = true;
  for (int i = 1; i < argc; ++i)
    with_inflation = with_inflation && std::strcmp(argv[i], "--no-inflation") != 0;
  row("threads", 1, default_threads(), "count");
  growth(false, "t10_incompatible");
  growth(true, "t10_compatible");
  if (!with_inflation) return 0;
  inflation(false, "t10_incompatible");
  inflation(true, "t10_compatible");
  return 0;
}
