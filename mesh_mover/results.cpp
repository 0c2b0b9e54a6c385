// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/results.hpp"

#include <system_error>

#include "common/base/log.hpp"
#include "common/io/positions.hpp"

namespace drogue::mesh_mover {

Result<Results> Results::create(const OutputSettings& settings, io::Existing existing) {
  std::error_code failure;
  std::filesystem::create_directories(settings.directory, failure);
  if (failure)
    return internal_error("cannot create the folder {}: {}", settings.directory.string(), failure.message());
  auto series = io::CsvWriter::create(settings.directory / "mesh.csv",
                                      {"step",
                                       "time",
                                       "iterations",
                                       "residual",
                                       "min_volume_ratio",
                                       "max_volume_ratio",
                                       "worst_mean_ratio",
                                       "mean_mean_ratio",
                                       "worst_x",
                                       "worst_y",
                                       "worst_z",
                                       "sub_increments",
                                       "f_A",
                                       "f_AR",
                                       "smallest_angle",
                                       "mean_ratio_p1",
                                       "mean_ratio_p10",
                                       "mean_ratio_p50",
                                       "angle_p1",
                                       "angle_p10",
                                       "angle_p50"},
                                      existing);
  if (!series) return series.error();
  Results results;
  results.settings_ = settings;
  results.series_ = std::move(*series);
  results.collection_ = io::PvdCollection(settings.directory / "mesh.pvd");
  return results;
}

Result<void> Results::save_positions(const std::filesystem::path& file) {
  return io::save_positions(file, {{&series_}, {&collection_}});
}

Result<void> Results::restore_positions(const std::filesystem::path& file) {
  return io::restore_positions(file, {{&series_}, {&collection_}});
}

Result<void> Results::write(const MeshMover& mover, std::uint64_t step, double time,
                            const SolveReport& report, bool is_last) {
  const auto every = [&](int interval) {
    return interval > 0 && step % static_cast<std::uint64_t>(interval) == 0;
  };
  const Quality& q = report.quality;
  if (!report.warning.empty()) spdlog::warn("step {} time {:.6g}: {}", step, time, report.warning);
  if (every(settings_.series_interval)) {
    const Distribution d = distribution(mover.points(), mover.cells());
    DROGUE_TRY(series_.row({static_cast<double>(step),
                            time,
                            static_cast<double>(report.iterations),
                            report.residual,
                            q.min_volume_ratio,
                            q.max_volume_ratio,
                            q.worst_mean_ratio,
                            q.mean_mean_ratio,
                            q.worst_place[0],
                            q.worst_place[1],
                            q.worst_place[2],
                            static_cast<double>(report.sub_increments),
                            q.f_A,
                            q.f_AR,
                            q.smallest_angle,
                            d.mean_ratio.p1,
                            d.mean_ratio.p10,
                            d.mean_ratio.p50,
                            d.angle.p1,
                            d.angle.p10,
                            d.angle.p50}));
  }
  if (every(settings_.field_interval) || (is_last && settings_.field_interval > 0))
    return write_fields(mover, step, time);
  return {};
}

Result<void> Results::write_fields(const MeshMover& mover, std::uint64_t step, double time) {
  const Cells& cells = mover.cells();
  std::vector<double> volume_ratio(cells.count());
  std::vector<double> mean_ratio(cells.count());
  for (std::size_t e = 0; e < cells.count(); ++e) {
    const CellShape shape = cell_shape(cells.dimension, mover.points(), cells.cell(e));
    volume_ratio[e] = shape.jacobian / mover.initial_shapes().jacobians[e];
    mean_ratio[e] = shape.mean_ratio;
  }
  io::VtuData data;
  data.points = mover.points();
  for (const auto& block : mover.mesh().blocks)
    if (mesh::dimension(block.kind) == cells.dimension) data.blocks.push_back(&block);
  const std::vector<double> displacement = mover.displacement_since_start();
  data.point_data = {{"displacement", 3, displacement}};
  data.cell_data = {{"volume_ratio", 1, volume_ratio}, {"mean_ratio", 1, mean_ratio}};
  const auto file = settings_.directory / fmt::format("mesh_{:06}.vtu", step);
  DROGUE_TRY(io::write_vtu(file, data));
  return collection_.add(time, file);
}

} // namespace drogue::mesh_mover
