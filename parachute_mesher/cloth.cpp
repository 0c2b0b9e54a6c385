// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/cloth.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <utility>

#include "parachute_mesher/cross_cloth.hpp"
#include "parachute_mesher/round_cloth.hpp"

namespace drogue::parachute {
namespace {

using mesh::ElementKind;

/// Rows of elements for each band between the gaps, in proportion to its length, each at least one.
std::vector<int> rows_of_bands(const std::vector<std::pair<double, double>>& bands, int rows) {
  double total = 0;
  for (const auto& [from, to] : bands) total += to - from;
  std::vector<int> result;
  double length = 0;
  int used = 0;
  for (std::size_t b = 0; b < bands.size(); ++b) {
    length += bands[b].second - bands[b].first;
    const int left = static_cast<int>(bands.size() - b) - 1;
    const int up_to = b + 1 == bands.size() ? rows : static_cast<int>(std::lround(rows * length / total));
    result.push_back(std::clamp(up_to - used, 1, rows - used - left));
    used += result.back();
  }
  return result;
}

ClothRows arm_rows(const Canopy& canopy, const Subdivision& subdivision) {
  ClothRows rows;
  const double from = 0.5 * canopy.arm_width_ratio * canopy.diameter;
  for (int i = 0; i <= subdivision.main_rows; ++i)
    rows.s.push_back(std::lerp(from, canopy.s_seam(), static_cast<double>(i) / subdivision.main_rows));
  rows.across.assign(rows.s.size(), subdivision.across_seam);
  rows.is_open.assign(rows.s.size(), false);
  return rows;
}

/// The point half-way between two: by s and theta on round canopies, straight on a cross.
ClothNode between(const Canopy& canopy, const ClothNode& a, const ClothNode& b) {
  if (canopy.shape == Shape::cross) {
    const auto p = material_position(a), q = material_position(b);
    const double x = 0.5 * (p[0] + q[0]), y = 0.5 * (p[1] + q[1]);
    return {std::hypot(x, y), std::atan2(y, x)};
  }
  return {0.5 * (a.s + b.s), a.theta + 0.5 * std::remainder(b.theta - a.theta, 2 * std::numbers::pi)};
}

/// Nodes in the middle of edges, each made once.
class EdgeNodes {
 public:
  EdgeNodes(const Canopy& canopy, std::vector<ClothNode>& nodes) : canopy_(canopy), nodes_(nodes) {}
  std::int32_t add(std::int32_t a, std::int32_t b) {
    const auto [found, is_new] = made_.emplace(std::minmax(a, b), static_cast<std::int32_t>(nodes_.size()));
    if (is_new) nodes_.push_back(between(canopy_, at(a), at(b)));
    return found->second;
  }
  /// `chain` with the middles of those of its links that are edges.
  [[nodiscard]] std::vector<std::int32_t> refined(const std::vector<std::int32_t>& chain) const {
    std::vector<std::int32_t> result{chain.front()};
    for (std::size_t i = 1; i < chain.size(); ++i) {
      const auto found = made_.find(std::minmax(chain[i - 1], chain[i]));
      if (found != made_.end()) result.push_back(found->second);
      result.push_back(chain[i]);
    }
    return result;
  }

 private:
  [[nodiscard]] ClothNode at(std::int32_t i) const { return nodes_[static_cast<std::size_t>(i)]; }

  const Canopy& canopy_;
  std::vector<ClothNode>& nodes_;
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> made_;
};

Cloth with_corners(const Canopy& canopy, const ClothRows& rows, ElementKind kind) {
  return canopy.shape == Shape::cross ? cross_cloth(canopy, rows, kind) : round_cloth(canopy, rows, kind);
}

/// Six-node triangles or nine-node quadrilaterals from those with corners alone.
Cloth elevated(const Canopy& canopy, Cloth cloth) {
  const bool quadrilateral = cloth.kind == ElementKind::quad4;
  const std::size_t corners = quadrilateral ? 4 : 3;
  EdgeNodes edges(canopy, cloth.nodes);
  std::vector<std::int32_t> elements;
  for (std::size_t e = 0; e < cloth.elements.size(); e += corners) {
    const std::int32_t* corner = &cloth.elements[e];
    elements.insert(elements.end(), corner, corner + corners);
    std::array<std::int32_t, 4> middle{};
    for (std::size_t i = 0; i < corners; ++i) {
      middle[i] = edges.add(corner[i], corner[(i + 1) % corners]);
      elements.push_back(middle[i]);
    }
    if (!quadrilateral) continue;
    elements.push_back(static_cast<std::int32_t>(cloth.nodes.size()));
    cloth.nodes.push_back(between(canopy, cloth.nodes[static_cast<std::size_t>(middle[0])],
                                  cloth.nodes[static_cast<std::size_t>(middle[2])]));
  }
  for (auto& radial : cloth.radials) radial = edges.refined(radial);
  cloth.elements = std::move(elements);
  cloth.kind = quadrilateral ? ElementKind::quad9 : ElementKind::tri6;
  return cloth;
}

} // namespace

ClothRows cloth_rows(const Canopy& canopy, const Subdivision& subdivision) {
  if (canopy.shape == Shape::cross) return arm_rows(canopy, subdivision);
  ClothRows rows;
  const auto add = [&](double s, double across) {
    rows.s.push_back(s);
    rows.across.push_back(std::max(1, static_cast<int>(std::lround(across))));
    rows.is_open.push_back(false);
  };
  // The main part, in units x of the length from the vent edge to the seam.
  const double vent = canopy.s_vent(), length = canopy.s_seam() - vent;
  std::vector<std::pair<double, double>> bands{{0, 1}};
  for (const Gap& gap : canopy.gaps) {
    bands.back().second = (gap.from * canopy.s_seam() - vent) / length;
    bands.emplace_back((gap.to * canopy.s_seam() - vent) / length, 1);
  }
  const std::vector<int> row_counts = rows_of_bands(bands, subdivision.main_rows);
  for (std::size_t b = 0; b < bands.size(); ++b) {
    if (b > 0) rows.is_open.back() = true;
    for (int i = 0; i <= row_counts[b]; ++i) {
      const double x = std::lerp(bands[b].first, bands[b].second, static_cast<double>(i) / row_counts[b]);
      add(std::lerp(vent, canopy.s_seam(), x),
          std::lerp(double(subdivision.across_vent), double(subdivision.across_seam),
                    std::pow(x, subdivision.across_exponent)));
    }
  }
  for (int i = 1; i <= subdivision.skirt_rows; ++i) {
    const double x = static_cast<double>(i) / subdivision.skirt_rows;
    add(std::lerp(canopy.s_seam(), canopy.s_skirt(), x),
        std::lerp(double(subdivision.across_seam), double(subdivision.across_skirt), x));
  }
  return rows;
}

Cloth triangulate_cloth(const Canopy& canopy, const ClothRows& rows) {
  return with_corners(canopy, rows, ElementKind::tri3);
}

Cloth mesh_cloth(const Canopy& canopy, const ClothRows& rows, ElementKind kind) {
  if (kind == ElementKind::tri6) return elevated(canopy, triangulate_cloth(canopy, rows));
  if (kind == ElementKind::quad9) return elevated(canopy, with_corners(canopy, rows, ElementKind::quad4));
  return with_corners(canopy, rows, kind);
}

} // namespace drogue::parachute
