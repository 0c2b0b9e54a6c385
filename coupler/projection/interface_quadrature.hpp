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
  /// Whether tractions are to be recovered from the forces: LoadTransfer then factors a mass matrix of the
  /// structure.
  bool recover_traction = true;
};

/// What the pairing of two surfaces found.
struct MatchReport {
  std::int64_t points = 0; ///< of the quadrature; a part of the common refinement counts as three
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

/// Integrals over each fluid element of the products of its shape functions N_b with those of the structure,
/// N_a, taken at the closest point pi in material coordinates. Both directions of the projection are made of
/// them.
///
/// Where both surfaces are linear triangles they are exact, on the common refinement of the two
/// (TriangleTiling; pi is then the projection along the fluid triangle's normal). Everywhere else, and where
/// triangles of the structure do not cover the fluid's (free edges, folds), they are sums over quadrature
/// points: on lines the rule of the common refinement, on faces composite rules, refined where an element of
/// the structure would get too few points.
class InterfaceQuadrature {
 public:
  struct Rule {
    mesh::ElementKind kind = mesh::ElementKind::tri3;
    int subdivisions = 1;
    std::vector<double> weights;
    std::vector<ElementShape> shapes;
  };
  struct Element {
    mesh::ElementKind kind = mesh::ElementKind::tri3;
    std::span<const std::int32_t> nodes;
    double share = 1; ///< one over the number of fluid layers here
    /// The structure's nodes that take part, and where the products with each of this element's nodes start:
    /// block(e)[a * nodes.size() + b].
    std::int64_t first_node = 0, first_value = 0;
    std::int32_t node_count = 0;
    /// Curved elements keep their points, for areas change there with the shape; -1 on flat ones.
    std::int32_t rule = -1;
    std::int64_t first_point = 0;
  };

  /// A point of the fluid and its closest one on the structure.
  struct Sample {
    std::int32_t fluid_element = -1, structure_element = -1;
    std::array<double, 2> on_fluid{}, on_structure{}; ///< parent coordinates
    double weight = 0;                                ///< reference area
  };

  /// @pre complete() accepted both surfaces
  /// Errors (ErrorKind::config): the surfaces lie too far from one another (says how many points, how far and
  /// where), or at too large an angle.
  [[nodiscard]] static Result<InterfaceQuadrature> create(const Surface& structure, const Surface& fluid,
                                                          const Settings& settings);

  /// {fluid elements}
  [[nodiscard]] const std::vector<Element>& elements() const { return elements_; }
  [[nodiscard]] std::span<const std::int32_t> block_nodes(const Element& e) const {
    return {block_nodes_.data() + e.first_node, static_cast<std::size_t>(e.node_count)};
  }
  /// int N_a(pi) N_b: on flat elements dxi deta over the parent domain, on curved ones dA over the reference
  /// area.
  [[nodiscard]] const double* block(const Element& e) const { return block_values_.data() + e.first_value; }
  /// Of all elements, from which first_node and first_value count.
  [[nodiscard]] const std::int32_t* all_block_nodes() const { return block_nodes_.data(); }
  [[nodiscard]] const double* all_blocks() const { return block_values_.data(); }

  /// On curved elements: rule, and structure nodes around a point with their shape functions there.
  [[nodiscard]] const Rule& rule(const Element& e) const { return rules_[static_cast<std::size_t>(e.rule)]; }
  [[nodiscard]] std::span<const std::int32_t> structure_nodes(std::int64_t point) const {
    return {point_nodes_.data() + first(point), first(point + 1) - first(point)};
  }
  [[nodiscard]] std::span<const double> structure_N(std::int64_t point) const {
    return {point_N_.data() + first(point), first(point + 1) - first(point)};
  }

  [[nodiscard]] const Elements& structure_elements() const { return *structure_elements_; }
  /// int N_a N_b dA over what of an element of the structure is wet, one layer of fluid: {nodes, nodes}.
  [[nodiscard]] const double* wet_mass(std::int32_t structure_element) const {
    return wet_mass_.data() + first_mass_[static_cast<std::size_t>(structure_element)];
  }
  /// Whether that part is large enough, and has enough points, to stand for the element.
  [[nodiscard]] bool wet(std::int32_t structure_element) const {
    return wet_[static_cast<std::size_t>(structure_element)] != 0;
  }
  /// Points to compare the two surfaces' fields in: all of a quadrature of the fluid, on large surfaces that
  /// of every k-th element.
  [[nodiscard]] const std::vector<Sample>& samples() const { return samples_; }
  [[nodiscard]] const Elements& fluid_elements() const { return *fluid_elements_; }
  [[nodiscard]] const MatchReport& report() const { return report_; }

 private:
  friend class Pairing;
  [[nodiscard]] std::size_t first(std::int64_t point) const {
    return static_cast<std::size_t>(point_offsets_[static_cast<std::size_t>(point)]);
  }

  std::shared_ptr<const Elements> fluid_elements_, structure_elements_;
  std::vector<Rule> rules_;
  std::vector<Element> elements_;
  std::vector<std::int32_t> block_nodes_;
  std::vector<double> block_values_;
  std::vector<std::int64_t> point_offsets_{0};
  std::vector<std::int32_t> point_nodes_;
  std::vector<double> point_N_;
  std::vector<std::int64_t> first_mass_;
  std::vector<double> wet_mass_;
  std::vector<char> wet_;
  std::vector<Sample> samples_;
  MatchReport report_;
};

} // namespace drogue::projection
