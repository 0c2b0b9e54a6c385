// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parachute_mesher/fluid_mesh.hpp"
#include "tests/parachute_mesher/inflated_shape.hpp"
#include "tests/support/t10_structure.hpp"

/// Fluid meshes round an inflated T-10 (feet), for benchmarks: the shape is that of a formula, no inflation
/// is run.
namespace drogue::test {

/// What sets the size of a mesh.
struct T10FluidSize {
  const char* name;
  parachute::Subdivision canopy;
  double canopy_size;
  double largest_size;
  double growth;
  double wake_size;
};
inline constexpr T10FluidSize t10_fluid_small{
    "17k", {.main_rows = 16, .skirt_rows = 4, .across_vent = 1, .across_seam = 4, .across_skirt = 3},
    0.85,  26,
    0.21,  2.1};
/// About the paper's 133,000 nodes: the canopy has the elements of the compatible structure mesh.
inline constexpr T10FluidSize t10_fluid_paper{"134k",
                                              {.main_rows = 42,
                                               .skirt_rows = 9,
                                               .across_vent = 1,
                                               .across_seam = 8,
                                               .across_skirt = 6,
                                               .across_exponent = 0.584},
                                              0.42,
                                              16,
                                              0.16,
                                              1.3};
inline constexpr T10FluidSize t10_fluid_large{"500k",
                                              {.main_rows = 60,
                                               .skirt_rows = 13,
                                               .across_vent = 1,
                                               .across_seam = 12,
                                               .across_skirt = 9,
                                               .across_exponent = 0.584},
                                              0.3,
                                              11,
                                              0.11,
                                              0.75};

[[nodiscard]] inline Result<mesh::Mesh> t10_fluid_mesh(const T10FluidSize& size) {
  const mesh::Mesh structure = t10_mesh(false);
  const parachute::ClothRows rows = parachute::cloth_rows(t10_canopy, size.canopy);
  const auto surface = parachute::inflated_canopy(t10_canopy, rows, structure,
                                                  parachute::inflated_displacement(t10_canopy, structure));
  if (!surface) return surface.error();
  auto made = parachute::fluid_mesh(t10_canopy,
                                    {.file = {},
                                     .structure_mesh = {},
                                     .structure_state = {},
                                     .rows = rows,
                                     .half_width = 105,
                                     .upstream = 105,
                                     .downstream = 175,
                                     .canopy_size = size.canopy_size,
                                     .largest_size = size.largest_size,
                                     .growth = size.growth,
                                     .wake_size = size.wake_size,
                                     .wake_length = 56},
                                    *surface);
  if (!made) return made.error();
  return std::move(made->mesh);
}

} // namespace drogue::test
