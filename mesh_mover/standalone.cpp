// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/standalone.hpp"

#include "common/base/interrupt.hpp"
#include "common/base/log.hpp"
#include "mesh_mover/remesher.hpp"
#include "mesh_mover/results.hpp"

namespace drogue::mesh_mover {
namespace {

Result<SolveReport> one_step(MeshMover& mover, double time_step, double time_np1) {
  DROGUE_TRY(mover.begin_step(time_step));
  BoundaryInput input;
  input.time = time_np1;
  auto report = mover.solve(input);
  if (report) mover.commit();
  return report;
}

} // namespace

Result<void> run_standalone(Case input, const std::filesystem::path& remesh_program) {
  const Settings settings = input.settings;
  auto created = MeshMover::create(std::move(input.mesh), settings);
  if (!created) return created.error();
  std::unique_ptr<MeshMover> mover = std::move(*created);
  Remesher remesher(settings, remesh_program);
  auto results = Results::create(settings.output);
  if (!results) return results.error();
  spdlog::info("{} nodes, {} {}", mover->mesh().node_count(), mover->cells().count(),
               mover->cells().plural());
  SolveReport start;
  start.quality = mover->current_quality();
  DROGUE_TRY(results->write(*mover, 0, 0, start, settings.steps == 0));
  for (int step = 1; step <= settings.steps; ++step) {
    const double time = step * settings.step;
    const auto report = one_step(*mover, settings.step, time);
    if (!report) {
      Error error = report.error();
      error.message = fmt::format("step {} (time {:.6g}): {}", step, time, error.message);
      return error;
    }
    const Quality& q = report->quality;
    spdlog::info(
        "step {} time {:.6g}: {} iterations, residual {:.2e}, {} sub-increments, smallest volume {:.3g} of "
        "the initial one, worst mean ratio {:.3g}, f_A {:.3g}, f_AR {:.3g}",
        step, time, report->iterations, report->residual, report->sub_increments, q.min_volume_ratio,
        q.worst_mean_ratio, q.f_A, q.f_AR);
    const bool stop = interrupted();
    DROGUE_TRY(results->write(*mover, static_cast<std::uint64_t>(step), time, *report,
                              stop || step == settings.steps));
    if (stop && step < settings.steps)
      return Error{ErrorKind::interrupted,
                   fmt::format("interrupted after step {} (time {:.6g}) of {}; its mesh is written", step,
                               time, settings.steps)};
    const auto replacement =
        remesher.after_step(*mover, q, static_cast<std::uint64_t>(step), settings.output.directory);
    if (!replacement) continue;
    mover.reset(); // one at a time: all ranks share its work
    auto replaced = mover_on(replacement->file, replacement->mesh_hash, settings);
    if (!replaced) return replaced.error();
    mover = std::move(*replaced);
  }
  return {};
}

} // namespace drogue::mesh_mover
