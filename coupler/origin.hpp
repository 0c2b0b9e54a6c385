// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>

#include "common/base/result.hpp"
#include "coupler/checkpoint_store.hpp"
#include "coupler/settings.hpp"

namespace drogue::coupler {

/// The end of another run, kept in the folder of the one that goes on from it.
struct Origin {
  std::uint64_t step = 0;
  std::filesystem::path folder;      ///< of the checkpoint's copy
  std::optional<MeshFile> mesh = {}; ///< in the place of the configs' mesh
};

/// Copies the newest whole checkpoint of the run in settings.start_from to `directory`/start, with the mesh
/// that had taken the place of its configs' mesh. Errors (ErrorKind::config): there is none, it has another
/// time step or no fewer steps than the case; (ErrorKind::internal): it cannot be copied.
[[nodiscard]] Result<Origin> keep_origin(const CaseSettings& settings,
                                         const std::filesystem::path& directory);

} // namespace drogue::coupler
