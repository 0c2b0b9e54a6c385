// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/round_cloth.hpp"

#include <cassert>
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

void fill_strip_with_quadrilaterals(const RowNumbering& number, std::size_t row, int g, int n,
                                    std::vector<std::int32_t>& elements) {
  for (int j = 0; j < n; ++j)
    elements.insert(elements.end(), {number.node(row, g, j), number.node(row + 1, g, j),
                                     number.node(row + 1, g, j + 1), number.node(row, g, j + 1)});
}

} // namespace

Cloth round_cloth(const Canopy& canopy, const ClothRows& rows, mesh::ElementKind kind) {
  Cloth cloth;
  cloth.kind = kind;
  const RowNumbering number(canopy, rows.across);
  place_nodes(canopy, rows, cloth);
  for (std::size_t row = 0; row + 1 < rows.s.size(); ++row) {
    if (rows.is_open[row]) continue;
    const int na = rows.across[row], nb = rows.across[row + 1];
    assert(kind == mesh::ElementKind::tri3 || na == nb);
    for (int g = 0; g < canopy.gores; ++g)
      if (kind == mesh::ElementKind::tri3)
        triangulate_strip(number, row, g, na, nb, cloth.elements);
      else
        fill_strip_with_quadrilaterals(number, row, g, na, cloth.elements);
  }
  const std::size_t last = rows.s.size() - 1;
  for (int g = 0; g < canopy.gores; ++g) {
    std::vector<std::int32_t>& radial = cloth.radials.emplace_back();
    for (std::size_t row = 0; row <= last; ++row) radial.push_back(number.node(row, g, 0));
    cloth.vent.push_back(radial.front());
    cloth.skirt.push_back(radial.back());
    for (int k = 0; k < rows.across[last]; ++k) cloth.rim.push_back(number.node(last, g, k));
  }
  return cloth;
}

} // namespace drogue::parachute
