// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/origin.hpp"

#include <cmath>

#include <spdlog/spdlog.h>

namespace drogue::coupler {

namespace fs = std::filesystem;

Result<Origin> keep_origin(const CaseSettings& settings, const fs::path& directory) {
  const CheckpointStore store(settings.start_from);
  const auto manifest = store.newest_whole();
  if (!manifest) return config_error("start_from: {}", manifest.error().message);
  const double expected = static_cast<double>(manifest->step) * settings.time_step;
  if (std::abs(manifest->time - expected) > 1e-9 * settings.time_step)
    return config_error(
        "start_from: the run in {} reached t = {:g} in {} steps: its step is not the {:g} of this case",
        settings.start_from.string(), manifest->time, manifest->step, settings.time_step);
  if (manifest->step >= static_cast<std::uint64_t>(settings.steps))
    return config_error(
        "start_from: the run in {} has done {} steps already; time.steps, which counts them in, is {}",
        settings.start_from.string(), manifest->step, settings.steps);
  Origin origin{manifest->step, directory / "start"};
  std::error_code failure;
  fs::copy(store.folder(manifest->step), origin.folder, fs::copy_options::recursive, failure);
  if (!failure && manifest->mesh) {
    origin.mesh = {origin.folder / manifest->mesh->path.filename(), manifest->mesh->mesh_hash};
    fs::copy_file(manifest->mesh->path, origin.mesh->path, failure);
  }
  if (failure)
    return internal_error("cannot copy the checkpoint in {} to {}: {}", store.folder(manifest->step).string(),
                          origin.folder.string(), failure.message());
  spdlog::info("goes on from step {} (t = {:g}) of the run in {}", manifest->step, manifest->time,
               settings.start_from.string());
  return origin;
}

} // namespace drogue::coupler
