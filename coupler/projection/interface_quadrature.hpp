// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>

#include "coupler/projection/surface.hpp"

namespace drogue::projection {

struct Settings {
  /// Largest distance, in material coordinates, between a point of one surface and the other, relative to the
  /// size of the surfaces.
  double largest_gap = 0.02;
  /// Degree of the quadrature on the fluid's elements.
  int quadrature_order = 4;
  /// Share of the fluid surface's reference area that may lie beyond the largest gap; 0: none. It takes part
  /// with its closest points, so that no load is lost.
  double largest_unmatched_area = 0;
  /// Largest angle between the two surfaces in any point, in material coordinates [degrees]; 90: any.
  double largest_normal_angle = 90;
};

/// What the pairing of two surfaces found.
struct MatchReport {
  std::int64_t points = 0;
  std::int64_t unmatched_points = 0;
  double unmatched_area = 0; ///< share of the fluid surface's reference area
  double largest_gap = 0;    ///< relative to the size of the structure, in material coordinates
  std::array<double, 3> largest_gap_at{};
  double worst_normal_angle =
      0; ///< degrees, between the two surfaces in material coordinates, whatever their sides
  std::array<double, 3> worst_normal_at{};
  double dry_area = 0;   ///< share of the structure's reference area with no fluid on it
  int fluid_sides = 1;   ///< largest number of fluid layers on one another
  bool matching = false; ///< the same elements on the same nodes: fields are copied
};

/// Quadrature points of the fluid surface (composite rules: elements that are larger than the structure's are
/// subdivided; on lines the common refinement of both meshes, so that all integrals are exact where the two
/// coincide), each with its closest point on the structure surface in material coordinates. Both directions
/// of the projection use these points, and they are located once.
class InterfaceQuadrature {
 public:
  struct Rule {
    mesh::ElementKind kind = mesh::ElementKind::tri3;
    int subdivisions = 1;
    std::vector<double> weights;
    std::vector<ElementShape> shapes;
  };
  struct Element {
    std::span<const std::int32_t> nodes;
    std::int32_t rule = 0;
    std::int64_t first_point = 0;
    double share = 1; ///< one over the number of fluid layers here
  };

  /// @pre complete() accepted both surfaces
  /// @param refine {fluid elements} or empty: factor on the number of subdivisions
  /// Errors (ErrorKind::config): the surfaces lie too far from one another (says how many points, how far and
  /// where), or at too large an angle.
  [[nodiscard]] static Result<InterfaceQuadrature> create(const Surface& structure, const Surface& fluid,
                                                          const Settings& settings,
                                                          std::span<const int> refine = {});

  [[nodiscard]] const std::vector<Element>& elements() const { return elements_; }
  [[nodiscard]] const Rule& rule(const Element& e) const { return rules_[static_cast<std::size_t>(e.rule)]; }
  /// Structure nodes around a point, and their shape functions there.
  [[nodiscard]] std::span<const std::int32_t> structure_nodes(std::int64_t point) const {
    return {nodes_.data() + first(point), first(point + 1) - first(point)};
  }
  [[nodiscard]] std::span<const double> structure_N(std::int64_t point) const {
    return {N_.data() + first(point), first(point + 1) - first(point)};
  }
  [[nodiscard]] const MatchReport& report() const { return report_; }
  [[nodiscard]] MatchReport& report() { return report_; }
  /// {structure elements}: number of points on each, and reference area of one fluid layer on each.
  [[nodiscard]] const std::vector<std::int32_t>& points_on() const { return points_on_; }
  [[nodiscard]] const std::vector<double>& area_on() const { return area_on_; }

 private:
  [[nodiscard]] std::size_t first(std::int64_t point) const {
    return static_cast<std::size_t>(offsets_[static_cast<std::size_t>(point)]);
  }
  [[nodiscard]] std::int32_t add_rule(mesh::ElementKind kind, int subdivisions,
                                      std::span<const fem::SurfacePoint> points);
  [[nodiscard]] std::int32_t find_rule(mesh::ElementKind kind, int subdivisions, int order);
  void choose_rules(const Surface& structure, const Surface& fluid, const Settings& settings,
                    std::span<const int> refine);
  void locate(const Surface& structure, const Surface& fluid, const Settings& settings);

  std::shared_ptr<const Elements> fluid_elements_, structure_elements_;
  std::vector<Rule> rules_;
  std::vector<Element> elements_;
  std::vector<std::int64_t> offsets_{0};
  std::vector<std::int32_t> nodes_;
  std::vector<double> N_;
  std::vector<std::int32_t> points_on_;
  std::vector<double> area_on_;
  MatchReport report_;
};

} // namespace drogue::projection
