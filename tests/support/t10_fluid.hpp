// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "parachute_mesher/fluid_mesh.hpp"
#include "tests/parachute_mesher/inflated_shape.hpp"
#include "tests/support/t10_structure.hpp"

/// Fluid meshes round an inflated T-10 (feet), for benchmarks: the shape is that of a formula, no inflation
/// is run.
namespace drogue::test {

/// What sets the size of a mesh: the canopy's triangles, and the elements at the canopy and in the wake [ft].
struct T10FluidSize {
  const char* name; ///< about how many nodes
  parachute::Subdivision canopy;
  double canopy_size;
  double wake_size;
};
// clang-format off
inline constexpr T10FluidSize t10_fluid_smallest{"17k",
    {.main_rows = 13, .skirt_rows = 3, .across_vent = 1, .across_seam = 3, .across_skirt = 3, .across_exponent = 0.584},
    1.1, 2.2};
inline constexpr T10FluidSize t10_fluid_small{"25k",
    {.main_rows = 16, .skirt_rows = 4, .across_vent = 1, .across_seam = 4, .across_skirt = 3, .across_exponent = 0.584},
    0.9, 1.8};
inline constexpr T10FluidSize t10_fluid_middle{"60k",
    {.main_rows = 26, .skirt_rows = 6, .across_vent = 1, .across_seam = 5, .across_skirt = 4, .across_exponent = 0.584},
    0.6, 1.2};
/// The paper's 133,000 nodes within 2 %; the canopy has the elements of the compatible structure mesh.
inline constexpr T10FluidSize t10_fluid_paper{"133k",
    {.main_rows = 42, .skirt_rows = 9, .across_vent = 1, .across_seam = 8, .across_skirt = 6, .across_exponent = 0.584},
    0.38, 0.81};
inline constexpr T10FluidSize t10_fluid_large{"500k",
    {.main_rows = 70, .skirt_rows = 15, .across_vent = 2, .across_seam = 13, .across_skirt = 10, .across_exponent = 0.584},
    0.23, 0.46};
// clang-format on

/// @param fullness see inflated_displacement()
[[nodiscard]] inline Result<parachute::CanopySurface> t10_surface(const T10FluidSize& size,
                                                                  double fullness = 0.35) {
  const mesh::Mesh structure = t10_mesh(false);
  return parachute::inflated_canopy(t10_canopy, parachute::cloth_rows(t10_canopy, size.canopy), structure,
                                    parachute::inflated_displacement(t10_canopy, structure, fullness));
}

[[nodiscard]] inline Result<parachute::FluidMeshResult>
t10_fluid_mesh(const T10FluidSize& size, const parachute::CanopySurface& surface) {
  return parachute::fluid_mesh(t10_canopy,
                               {.file = {},
                                .structure_mesh = {},
                                .structure_state = {},
                                .rows = parachute::cloth_rows(t10_canopy, size.canopy),
                                .half_width = 105,
                                .upstream = 105,
                                .downstream = 175,
                                .canopy_size = size.canopy_size,
                                .largest_size = 32,
                                .growth = 0.15,
                                .wake_size = size.wake_size,
                                .wake_length = 56},
                               surface);
}

[[nodiscard]] inline Result<mesh::Mesh> t10_fluid_mesh(const T10FluidSize& size) {
  const auto surface = t10_surface(size);
  if (!surface) return surface.error();
  auto made = t10_fluid_mesh(size, *surface);
  if (!made) return made.error();
  return std::move(made->mesh);
}

} // namespace drogue::test
