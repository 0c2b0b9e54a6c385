// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/material_map.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "common/fem/shape.hpp"

namespace drogue::parachute {
namespace {

using Pair = std::array<double, 2>;
constexpr double margin = 0.1; ///< how far outside an element a point may be, in units of the element's size

/// The nearest point of the parent domain (for triangles: along the normal of the hypotenuse).
Pair clamped(mesh::ElementKind kind, Pair xi) {
  if (fem::is_quadrilateral(kind)) return {std::clamp(xi[0], -1.0, 1.0), std::clamp(xi[1], -1.0, 1.0)};
  const double excess = std::max(0.0, 0.5 * (xi[0] + xi[1] - 1));
  return {std::clamp(xi[0] - excess, 0.0, 1.0), std::clamp(xi[1] - excess, 0.0, 1.0)};
}

} // namespace

Result<MaterialMap> MaterialMap::create(const mesh::Mesh& m, const std::string& group) {
  MaterialMap map;
  const auto field = m.node_fields.find("material");
  if (field == m.node_fields.end() || field->second.components != 3)
    return config_error("the structure mesh has no node field \"material\" of 3 components");
  map.material_ = field->second.values;
  for (const mesh::ElementBlock* block : m.blocks_of(group)) {
    if (mesh::dimension(block->kind) != 2) continue;
    for (std::int32_t e = 0; e < block->count(); ++e) {
      const auto nodes = block->element(e);
      constexpr double infinity = std::numeric_limits<double>::infinity();
      Element element{
          block->kind, {nodes.begin(), nodes.end()}, {infinity, infinity}, {-infinity, -infinity}, 0};
      for (const std::int32_t node : nodes)
        for (std::size_t i = 0; i < 2; ++i) {
          const double x = map.material(node)[i];
          if (!std::isfinite(x))
            return config_error("nodes of the group \"{}\" have no material coordinates", group);
          element.low[i] = std::min(element.low[i], x);
          element.high[i] = std::max(element.high[i], x);
        }
      element.size = std::hypot(element.high[0] - element.low[0], element.high[1] - element.low[1]);
      for (std::size_t i = 0; i < 2; ++i) {
        element.low[i] -= margin * element.size;
        element.high[i] += margin * element.size;
      }
      map.elements_.push_back(std::move(element));
    }
  }
  if (map.elements_.empty()) return config_error("the structure mesh has no surface elements \"{}\"", group);
  return map;
}

Pair MaterialMap::material(std::int32_t node) const {
  const std::size_t i = 3 * static_cast<std::size_t>(node);
  return {material_[i], material_[i + 1]};
}

MaterialMap::Location MaterialMap::locate_in(const Element& element, double x, double y) const {
  Pair xi = fem::parent_centre(element.kind);
  Pair residual{};
  const auto linearise = [&] {
    const fem::SurfaceShape shape = fem::surface_shape(element.kind, xi[0], xi[1]);
    residual = {x, y};
    std::array<Pair, 2> jacobian{};
    for (std::size_t a = 0; a < element.nodes.size(); ++a) {
      const Pair X = material(element.nodes[a]);
      for (std::size_t i = 0; i < 2; ++i) {
        residual[i] -= shape.N[a] * X[i];
        jacobian[i][0] += shape.dN_dxi[a] * X[i];
        jacobian[i][1] += shape.dN_deta[a] * X[i];
      }
    }
    return jacobian;
  };
  for (int iteration = 0; iteration < 20; ++iteration) {
    const auto J = linearise();
    const double det = J[0][0] * J[1][1] - J[0][1] * J[1][0];
    if (std::hypot(residual[0], residual[1]) < 1e-13 * element.size || det == 0) break;
    xi[0] += (J[1][1] * residual[0] - J[0][1] * residual[1]) / det;
    xi[1] += (J[0][0] * residual[1] - J[1][0] * residual[0]) / det;
    for (double& c : xi) c = std::clamp(c, -2.0, 2.0);
  }
  xi = clamped(element.kind, xi);
  linearise();
  return {&element, xi, std::hypot(residual[0], residual[1])};
}

std::optional<std::array<double, 3>> MaterialMap::interpolate(const std::vector<double>& values, double x,
                                                              double y) const {
  Location best{nullptr, {}, std::numeric_limits<double>::infinity()};
  for (const Element& element : elements_) {
    if (x < element.low[0] || x > element.high[0] || y < element.low[1] || y > element.high[1]) continue;
    const Location found = locate_in(element, x, y);
    if (found.distance < best.distance) best = found;
  }
  if (best.element == nullptr || best.distance > margin * best.element->size) return std::nullopt;
  const fem::SurfaceShape shape = fem::surface_shape(best.element->kind, best.xi[0], best.xi[1]);
  std::array<double, 3> result{};
  for (std::size_t a = 0; a < best.element->nodes.size(); ++a)
    for (std::size_t i = 0; i < 3; ++i)
      result[i] += shape.N[a] * values[3 * static_cast<std::size_t>(best.element->nodes[a]) + i];
  return result;
}

} // namespace drogue::parachute
