// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <filesystem>
#include <optional>

#include "common/base/result.hpp"
#include "parachute_mesher/cloth.hpp"

namespace drogue::parachute {

/// Four risers and a payload of six trusses under them; see the config schema. Lengths [length].
struct Risers {
  double length = 0;
  int elements = 1;
  double confluence_depth = 0;
  double payload_width = 0;
  double payload_height = 0;
};

/// Lines below the canopy and across its vent.
struct Rigging {
  double line_length = 0; ///< [length]
  int line_elements = 1;
  int vent_elements = 1;          ///< 0: no vent lines
  double confluence_distance = 0; ///< [length]; 0: one confluence point
  int inner_line_elements = 0;    ///< from the vent edge to the confluence points; 0: none
  std::optional<Risers> risers = {};
};

struct StructureSettings {
  std::filesystem::path file;
  mesh::ElementKind element = mesh::ElementKind::tri3;
  ClothRows rows;
};

struct FluidSettings {
  std::filesystem::path file;
  std::filesystem::path structure_mesh;
  std::filesystem::path structure_state;
  ClothRows rows;
  double half_width = 0; ///< [length]
  double upstream = 0;   ///< below the skirt [length]
  double downstream = 0; ///< above the skirt [length]
  double canopy_size = 0;
  double largest_size = 0;
  double growth = 0;
  double wake_size = 0; ///< [length]; largest_size when the config gives none
  double wake_length = 0;
};

struct Settings {
  Canopy canopy;
  Rigging rigging;
  std::optional<StructureSettings> structure;
  std::optional<FluidSettings> fluid;
};

/// Reads and checks a ParachuteConfig. Errors (ErrorKind::config): every error of the file, a line each.
[[nodiscard]] Result<Settings> load_settings(const std::filesystem::path& file);

} // namespace drogue::parachute
