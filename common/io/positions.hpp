// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <vector>

#include "common/io/csv.hpp"
#include "common/io/vtu.hpp"

namespace drogue::io {

/// The result files of one process, for a checkpoint: how far each was written. No pointer is null.
struct ResultFiles {
  std::vector<CsvWriter*> series;
  std::vector<PvdCollection*> collections;
};

/// Notes in a state file how long every series, and how far every collection, is.
[[nodiscard]] Result<void> save_positions(const std::filesystem::path& file, const ResultFiles& files);
/// Cuts the files to these lengths; later ones are continued from there. Errors (ErrorKind::config): the
/// state file is damaged or knows nothing of one of them, or one of them is shorter.
[[nodiscard]] Result<void> restore_positions(const std::filesystem::path& file, const ResultFiles& files);

} // namespace drogue::io
