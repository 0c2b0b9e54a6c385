// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/interface_quadrature.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "coupler/projection/line_refinement.hpp"
#include "coupler/projection/surface_tree.hpp"

namespace drogue::projection {
namespace {

using Eigen::Vector3d;
using mesh::ElementKind;

constexpr int max_subdivisions = 16;
/// Two fluid layers lie on one another when they are this close, relative to the size.
constexpr double same_place = 1e-8;

Error too_far(const MatchReport& r, const Surface& structure, const Surface& fluid,
              const Settings& settings) {
  return config_error("the {} surface and the {} surface do not lie on one another: {} of {} points of the "
                      "first ({:.2g} % of its area) "
                      "are further from the second than {:.3g} of its size; the largest gap is {:.3g} of the "
                      "size, at ({:.6g}, {:.6g}, "
                      "{:.6g}) in material coordinates. Check the units, positions and material coordinates "
                      "of the two meshes, or "
                      "raise projection.largest_gap",
                      fluid.name, structure.name, r.unmatched_points, r.points, 100 * r.unmatched_area,
                      settings.largest_gap, r.largest_gap, r.largest_gap_at[0], r.largest_gap_at[1],
                      r.largest_gap_at[2]);
}

Error too_oblique(const MatchReport& r, const Surface& structure, const Surface& fluid,
                  const Settings& settings) {
  return config_error(
      "the {} surface and the {} surface stand at {:.3g} degrees to one another at ({:.6g}, "
      "{:.6g}, {:.6g}) in material coordinates; {:.3g} are allowed. Refine the coarser mesh where "
      "it is bent, or raise projection.largest_normal_angle",
      fluid.name, structure.name, r.worst_normal_angle, r.worst_normal_at[0], r.worst_normal_at[1],
      r.worst_normal_at[2], settings.largest_normal_angle);
}

} // namespace

std::int32_t InterfaceQuadrature::add_rule(ElementKind kind, int subdivisions,
                                           std::span<const fem::SurfacePoint> points) {
  Rule rule;
  rule.kind = kind;
  rule.subdivisions = subdivisions;
  for (const fem::SurfacePoint& q : points) {
    rule.weights.push_back(q.weight);
    rule.shapes.push_back(element_shape(kind, q.xi, q.eta));
  }
  rules_.push_back(std::move(rule));
  return static_cast<std::int32_t>(rules_.size()) - 1;
}

std::int32_t InterfaceQuadrature::find_rule(ElementKind kind, int subdivisions, int order) {
  for (std::size_t i = 0; i < rules_.size(); ++i)
    if (rules_[i].kind == kind && rules_[i].subdivisions == subdivisions) return static_cast<std::int32_t>(i);
  return add_rule(kind, subdivisions, composite_quadrature(kind, order, subdivisions));
}

void InterfaceQuadrature::choose_rules(const Surface& structure, const Surface& fluid,
                                       const Settings& settings, std::span<const int> refine) {
  const SurfaceTree structure_tree(*structure_elements_, structure.material);
  const SurfaceTree fluid_tree(*fluid_elements_, fluid.material);
  const double tolerance = same_place * extent(structure.material);
  std::int32_t hint = -1;
  std::int64_t points = 0;
  for (std::int32_t e = 0; e < fluid_elements_->count(); ++e) {
    const ElementKind kind = fluid_elements_->kind(e);
    const NodeMatrix X = gather(fluid_elements_->nodes(e), fluid.material);
    const auto at = [&](const std::array<double, 2>& parent) {
      const auto shape = element_shape(kind, parent[0], parent[1]);
      return combine(shape.N, shape.nodes, X);
    };
    // For the layers a point away from the diagonals and medians, where another layer may have its edges.
    const bool has_corner_at_zero = kind == ElementKind::tri3 || kind == ElementKind::tri6;
    const Vector3d inside = at(has_corner_at_zero ? std::array{0.371, 0.293} : std::array{0.137, 0.061});
    const int layers = std::max(fluid_tree.layers(inside, tolerance), 1);
    report_.fluid_sides = std::max(report_.fluid_sides, layers);
    std::int32_t rule = 0;
    if (mesh::dimension(kind) == 1) {
      const auto breaks = refine_line(kind, X, structure_tree);
      rule = add_rule(kind, static_cast<int>(breaks.size()) - 1,
                      line_quadrature(breaks, settings.quadrature_order));
    } else {
      // The centre: both sides of a canopy are to get the same rule.
      hint = structure_tree.closest(at(parent_centre(kind)), hint).element;
      const double spacing = node_spacing(structure_elements_->kind(hint),
                                          gather(structure_elements_->nodes(hint), structure.material));
      const int wanted =
          static_cast<int>(std::min(std::round(longest_edge(kind, X) / spacing), 1.0 * max_subdivisions));
      const int n = std::min((refine.empty() ? 1 : refine[static_cast<std::size_t>(e)]) * std::max(wanted, 1),
                             max_subdivisions);
      rule = find_rule(kind, n, settings.quadrature_order);
    }
    elements_.push_back({fluid_elements_->nodes(e), rule, points, 1.0 / layers});
    points +=
        static_cast<std::int64_t>(rules_[static_cast<std::size_t>(elements_.back().rule)].weights.size());
  }
  report_.points = points;
}

void InterfaceQuadrature::locate(const Surface& structure, const Surface& fluid, const Settings& settings) {
  const SurfaceTree tree(*structure_elements_, structure.material);
  const double size = extent(structure.material), allowed = settings.largest_gap * size;
  points_on_.assign(static_cast<std::size_t>(structure_elements_->count()), 0);
  area_on_.assign(points_on_.size(), 0.0);
  offsets_.reserve(static_cast<std::size_t>(report_.points) + 1);
  double area = 0, unmatched = 0, largest = 0, worst_cosine = 1;
  std::int32_t hint = -1;
  for (const Element& element : elements_) {
    const Rule& r = rule(element);
    const NodeMatrix material = gather(element.nodes, fluid.material),
                     reference = gather(element.nodes, fluid.reference);
    for (std::size_t q = 0; q < r.weights.size(); ++q) {
      const ElementShape& shape = r.shapes[q];
      const Vector3d p = combine(shape.N, shape.nodes, material);
      const Located found = tree.closest(p, hint);
      hint = found.element;
      const ElementKind kind = structure_elements_->kind(hint);
      const auto nodes = structure_elements_->nodes(hint);
      const auto source = element_shape(kind, found.point.xi, found.point.eta);
      nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
      N_.insert(N_.end(), source.N.begin(), source.N.begin() + source.nodes);
      offsets_.push_back(static_cast<std::int64_t>(nodes_.size()));

      const double da = r.weights[q] * area_vector(shape, reference).norm();
      area += da;
      ++points_on_[static_cast<std::size_t>(hint)];
      area_on_[static_cast<std::size_t>(hint)] += element.share * da;
      const double gap = std::sqrt(found.point.distance2);
      if (gap > largest) {
        largest = gap;
        report_.largest_gap_at = {p[0], p[1], p[2]};
      }
      if (gap > allowed) {
        ++report_.unmatched_points;
        unmatched += da;
      }
      const Vector3d a = area_vector(shape, material),
                     b = area_vector(source, gather(nodes, structure.material));
      const double lengths = a.norm() * b.norm();
      if (lengths > 0 && std::abs(a.dot(b)) < worst_cosine * lengths) {
        worst_cosine = std::abs(a.dot(b)) / lengths;
        report_.worst_normal_at = {p[0], p[1], p[2]};
      }
    }
  }
  report_.unmatched_area = unmatched / area;
  report_.largest_gap = largest / size;
  report_.worst_normal_angle = std::acos(std::min(worst_cosine, 1.0)) * 180 / std::numbers::pi;
}

Result<InterfaceQuadrature> InterfaceQuadrature::create(const Surface& structure, const Surface& fluid,
                                                        const Settings& settings,
                                                        std::span<const int> refine) {
  InterfaceQuadrature made;
  made.structure_elements_ = std::make_shared<Elements>(structure);
  made.fluid_elements_ = std::make_shared<Elements>(fluid);
  made.choose_rules(structure, fluid, settings, refine);
  made.locate(structure, fluid, settings);
  const MatchReport& report = made.report_;
  if (report.unmatched_area > settings.largest_unmatched_area)
    return too_far(report, structure, fluid, settings);
  if (report.worst_normal_angle > settings.largest_normal_angle)
    return too_oblique(report, structure, fluid, settings);
  return made;
}

} // namespace drogue::projection
