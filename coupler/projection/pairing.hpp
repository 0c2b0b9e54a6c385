// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coupler/projection/interface_quadrature.hpp"
#include "coupler/projection/surface_tree.hpp"
#include "coupler/projection/triangle_tiling.hpp"

namespace drogue::projection {

/// Makes an InterfaceQuadrature, in these steps:
///  1. fluid layers on one another;
///  2. the common refinement, where both surfaces are linear triangles;
///  3. points on the fluid elements that are left, each with its closest point; more where they are too few;
///  4. products of shape functions, summed over those points;
///  5. what of the structure is wet;
///  6. some points to compare projected fields in.
class Pairing {
 public:
  Pairing(const Surface& structure, const Surface& fluid, const Settings& settings);
  [[nodiscard]] InterfaceQuadrature make();

 private:
  /// Where a point of a fluid element meets the structure.
  struct Meeting {
    std::int32_t element = -1;
    double xi = 0, eta = 0, gap = 0;
  };
  /// A fluid element with points.
  struct Sampled {
    std::int32_t element = -1;
    int refine = 1;
    std::int32_t rule = -1;
    std::int64_t first = 0; ///< in meetings_
    bool stale = true;      ///< to be located
  };

  void count_layers();
  void tile();
  [[nodiscard]] bool tile_element(TriangleTiling& tiling, std::int32_t e, std::int32_t& seed);
  void choose_rule(Sampled& s, std::int32_t& hint);
  void locate(Sampled& s, std::int32_t& hint);
  /// True when elements of the structure have fewer points than nodes; their neighbourhood is then marked
  /// stale.
  [[nodiscard]] bool refine_starved();
  void sum_points(const Sampled& s);
  void finish();
  void sample_for_defects();

  [[nodiscard]] std::int32_t add_rule(mesh::ElementKind kind, int subdivisions,
                                      std::span<const fem::SurfacePoint> points);
  [[nodiscard]] std::int32_t find_rule(mesh::ElementKind kind, int subdivisions);
  /// The row of a structure node in the block under construction.
  [[nodiscard]] double* row(std::int32_t node, std::size_t fluid_nodes);
  void start_block(std::int32_t e);
  void end_block(std::int32_t e);
  void see_gap(double gap, const Eigen::Vector3d& at);
  void see_normals(const Eigen::Vector3d& a, const Eigen::Vector3d& b, const Eigen::Vector3d& at);

  const Surface &structure_, &fluid_;
  const Settings& settings_;
  InterfaceQuadrature made_;
  const Elements &on_structure_, &on_fluid_;
  SurfaceTree tree_;
  double size_;
  double area_ = 0, unmatched_ = 0, largest_gap_ = 0, worst_cosine_ = 1;
  std::vector<Sampled> sampled_;
  std::vector<Meeting> meetings_;
  std::vector<std::int32_t> points_on_; ///< {structure elements}
  std::vector<double> area_on_;
  std::vector<std::int64_t>
      slot_; ///< {structure nodes}: start of its row in the block under construction, or -1
};

} // namespace drogue::projection
