// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/cloth.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstdlib>
#include <numbers>

namespace drogue::parachute {
namespace {

/// Numbers the nodes of a cloth: row i has across[i] nodes a gore, all around the canopy.
class RowNumbering {
 public:
  RowNumbering(const Canopy& canopy, const std::vector<int>& across) : gores_(canopy.gores), across_(across) {
    first_.push_back(0);
    for (const int n : across) first_.push_back(first_.back() + n * gores_);
  }
  /// Node `k` edges after the start of gore `g`; closes the circle.
  [[nodiscard]] std::int32_t node(std::size_t row, int g, int k) const {
    const int around = across_[row] * gores_;
    return first_[row] + (g * across_[row] + k) % around;
  }

 private:
  int gores_;
  const std::vector<int>& across_;
  std::vector<std::int32_t> first_;
};

void place_nodes(const Canopy& canopy, const ClothRows& rows, Cloth& cloth) {
  for (std::size_t row = 0; row < rows.s.size(); ++row) {
    const int around = rows.across[row] * canopy.gores;
    for (int j = 0; j < around; ++j)
      cloth.nodes.push_back({rows.s[row], 2 * std::numbers::pi * (j + 0.5 * rows.across[row]) / around});
  }
}

void collect_radials(const Canopy& canopy, std::size_t row_count, const RowNumbering& number, Cloth& cloth) {
  for (int g = 0; g < canopy.gores; ++g) {
    std::vector<std::int32_t>& radial = cloth.radials.emplace_back();
    for (std::size_t row = 0; row < row_count; ++row) radial.push_back(number.node(row, g, 0));
  }
}

/// Triangles of one gore between an inner row with `na` edges and the next with `nb`.
void triangulate_strip(const RowNumbering& number, std::size_t row, int g, int na, int nb,
                       std::vector<std::int32_t>& triangles) {
  int a = 0, b = 0;
  while (a < na || b < nb) {
    // Lengths of the two possible diagonals across the gore, in units of 1 / (na nb).
    const int diagonal_a = std::abs((a + 1) * nb - b * na);
    const int diagonal_b = std::abs((b + 1) * na - a * nb);
    const bool advance_a = b == nb || (a < na && diagonal_a <= diagonal_b);
    const std::int32_t at_a = number.node(row, g, a), at_b = number.node(row + 1, g, b);
    const std::int32_t next = advance_a ? number.node(row, g, ++a) : number.node(row + 1, g, ++b);
    triangles.insert(triangles.end(), {at_a, at_b, next});
  }
}

} // namespace

double Canopy::cloth_area() const {
  const auto disk = [](double r) { return std::numbers::pi * r * r; };
  return disk(s_seam()) - disk(s_vent()) + disk(s_seam()) - disk(flat_radius(s_skirt()));
}

ClothRows cloth_rows(const Canopy& canopy, const Subdivision& subdivision) {
  ClothRows rows;
  const auto add = [&](double s, double across) {
    rows.s.push_back(s);
    rows.across.push_back(std::max(1, static_cast<int>(std::lround(across))));
  };
  for (int i = 0; i <= subdivision.main_rows; ++i) {
    const double x = static_cast<double>(i) / subdivision.main_rows;
    add(std::lerp(canopy.s_vent(), canopy.s_seam(), x),
        std::lerp(double(subdivision.across_vent), double(subdivision.across_seam),
                  std::pow(x, subdivision.across_exponent)));
  }
  for (int i = 1; i <= subdivision.skirt_rows; ++i) {
    const double x = static_cast<double>(i) / subdivision.skirt_rows;
    add(std::lerp(canopy.s_seam(), canopy.s_skirt(), x),
        std::lerp(double(subdivision.across_seam), double(subdivision.across_skirt), x));
  }
  return rows;
}

Cloth triangulate_cloth(const Canopy& canopy, const ClothRows& rows) {
  Cloth cloth;
  const RowNumbering number(canopy, rows.across);
  place_nodes(canopy, rows, cloth);
  for (std::size_t row = 0; row + 1 < rows.s.size(); ++row)
    for (int g = 0; g < canopy.gores; ++g)
      triangulate_strip(number, row, g, rows.across[row], rows.across[row + 1], cloth.elements);
  collect_radials(canopy, rows.s.size(), number, cloth);
  return cloth;
}

Cloth quadratic_cloth(const Canopy& canopy, const ClothRows& rows) {
  assert(std::all_of(rows.across.begin(), rows.across.end(), [&](int n) { return n == rows.across[0]; }));
  ClothRows half;
  for (std::size_t row = 0; row < rows.s.size(); ++row) {
    if (row > 0) half.s.push_back(0.5 * (rows.s[row - 1] + rows.s[row]));
    half.s.push_back(rows.s[row]);
  }
  half.across.assign(half.s.size(), 2 * rows.across[0]);

  Cloth cloth;
  cloth.kind = mesh::ElementKind::quad9;
  const RowNumbering number(canopy, half.across);
  place_nodes(canopy, half, cloth);
  for (std::size_t i = 0; i + 2 < half.s.size(); i += 2)
    for (int g = 0; g < canopy.gores; ++g)
      for (int j = 0; j < half.across[0]; j += 2) {
        const auto node = [&](std::size_t di, int dj) { return number.node(i + di, g, j + dj); };
        cloth.elements.insert(cloth.elements.end(),
                              {node(0, 0), node(2, 0), node(2, 2), node(0, 2), // corners
                               node(1, 0), node(2, 1), node(1, 2), node(0, 1), // middles of the edges
                               node(1, 1)});
      }
  collect_radials(canopy, half.s.size(), number, cloth);
  return cloth;
}

std::array<double, 3> flat_position(const Canopy& canopy, const ClothNode& node) {
  const double r = canopy.flat_radius(node.s);
  return {r * std::cos(node.theta), r * std::sin(node.theta), 0};
}

std::array<double, 3> material_position(const ClothNode& node) {
  return {node.s * std::cos(node.theta), node.s * std::sin(node.theta), 0};
}

} // namespace drogue::parachute
