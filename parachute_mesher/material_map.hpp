// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "common/base/result.hpp"
#include "common/mesh/mesh.hpp"

namespace drogue::parachute {

/// Finds points of the cloth in a structure mesh by their material coordinates, in which main disk and skirt
/// lie side by side, and interpolates there. A point a little outside every element (the cloth's edge is a
/// polygon, and another one on every mesh) belongs to the nearest point of the nearest element.
class MaterialMap {
 public:
  /// Errors (ErrorKind::config): no such group of surface elements, no field "material", or nodes of the
  /// group without one.
  [[nodiscard]] static Result<MaterialMap> create(const mesh::Mesh& m, const std::string& group);

  /// Interpolates `values`, shape {node count, 3}, at material coordinates x, y. Nothing when the point is
  /// farther from the cloth than a tenth of the nearest element's size.
  [[nodiscard]] std::optional<std::array<double, 3>> interpolate(const std::vector<double>& values, double x,
                                                                 double y) const;

 private:
  struct Element {
    mesh::ElementKind kind;
    std::vector<std::int32_t> nodes;
    std::array<double, 2> low, high; ///< bounds of the material coordinates, widened
    double size;
  };
  struct Location {
    const Element* element;
    std::array<double, 2> xi;
    double distance;
  };
  [[nodiscard]] Location locate_in(const Element& element, double x, double y) const;
  [[nodiscard]] std::array<double, 2> material(std::int32_t node) const;

  std::vector<double> material_;
  std::vector<Element> elements_;
};

} // namespace drogue::parachute
