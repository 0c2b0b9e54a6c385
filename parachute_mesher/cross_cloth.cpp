// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <cmath>
#include <numbers>

#include "parachute_mesher/cross_cloth.hpp"

namespace drogue::parachute {
namespace {

constexpr std::int32_t none = -1;

/// The square grid of which a cross takes the middle row and the middle column of nine fields.
class CrossGrid {
 public:
  CrossGrid(const Canopy& canopy, const ClothRows& rows)
      : across_(rows.across.front()), along_(static_cast<int>(rows.s.size()) - 1) {
    const double half_width = 0.5 * canopy.arm_width_ratio * canopy.diameter;
    for (int i = along_; i > 0; --i) stations_.push_back(-rows.s[static_cast<std::size_t>(i)]);
    for (int i = 0; i <= across_; ++i) stations_.push_back(half_width * (2.0 * i / across_ - 1));
    for (int i = 1; i <= along_; ++i) stations_.push_back(rows.s[static_cast<std::size_t>(i)]);
    number_.assign(stations_.size() * stations_.size(), none);
  }
  [[nodiscard]] int last() const { return 2 * along_ + across_; }
  [[nodiscard]] int first_middle() const { return along_; }
  [[nodiscard]] bool has_node(int i, int j) const { return is_middle(i, 0) || is_middle(j, 0); }
  /// The cell between the nodes (i, j) and (i + 1, j + 1).
  [[nodiscard]] bool has_cell(int i, int j) const { return is_middle(i, 1) || is_middle(j, 1); }
  [[nodiscard]] std::int32_t& number(int i, int j) {
    return number_[static_cast<std::size_t>(j) * stations_.size() + static_cast<std::size_t>(i)];
  }
  [[nodiscard]] ClothNode node(int i, int j) const {
    const double x = stations_[static_cast<std::size_t>(i)], y = stations_[static_cast<std::size_t>(j)];
    return {std::hypot(x, y), std::atan2(y, x)};
  }

 private:
  [[nodiscard]] bool is_middle(int i, int extent) const {
    return i >= along_ && i + extent <= along_ + across_;
  }

  int across_;
  int along_;
  std::vector<double> stations_; ///< of both axes
  std::vector<std::int32_t> number_;
};

void add_cell(CrossGrid& grid, int i, int j, Cloth& cloth) {
  const std::int32_t a = grid.number(i, j), b = grid.number(i + 1, j), c = grid.number(i + 1, j + 1),
                     d = grid.number(i, j + 1);
  if (cloth.kind == mesh::ElementKind::quad4) {
    cloth.elements.insert(cloth.elements.end(), {a, b, c, d});
    return;
  }
  // Diagonals that keep the symmetry of the cross.
  const int middle = grid.last() - 1;
  if ((2 * i < middle) == (2 * j < middle))
    cloth.elements.insert(cloth.elements.end(), {a, b, c, a, c, d});
  else
    cloth.elements.insert(cloth.elements.end(), {a, b, d, b, c, d});
}

void add_lines(const Canopy& canopy, CrossGrid& grid, int across, Cloth& cloth) {
  const int step = across / (canopy.lines_per_arm - 1);
  for (const bool along_x : {true, false})
    for (int line = 0; line < canopy.lines_per_arm; ++line) {
      const int m = grid.first_middle() + line * step;
      std::vector<std::int32_t>& chain = cloth.radials.emplace_back();
      for (int i = 0; i <= grid.last(); ++i) chain.push_back(along_x ? grid.number(i, m) : grid.number(m, i));
      cloth.skirt.push_back(chain.front());
      cloth.skirt.push_back(chain.back());
    }
  const auto turn = [&](std::int32_t node) {
    const double theta = cloth.nodes[static_cast<std::size_t>(node)].theta;
    return theta < 0 ? theta + 2 * std::numbers::pi : theta;
  };
  std::sort(cloth.skirt.begin(), cloth.skirt.end(),
            [&](std::int32_t a, std::int32_t b) { return turn(a) < turn(b); });
}

} // namespace

Cloth cross_cloth(const Canopy& canopy, const ClothRows& rows, mesh::ElementKind kind) {
  Cloth cloth;
  cloth.kind = kind;
  CrossGrid grid(canopy, rows);
  const int last = grid.last();
  for (int j = 0; j <= last; ++j)
    for (int i = 0; i <= last; ++i) {
      if (!grid.has_node(i, j)) continue;
      grid.number(i, j) = static_cast<std::int32_t>(cloth.nodes.size());
      if (i == 0 || j == 0 || i == last || j == last) cloth.rim.push_back(grid.number(i, j));
      cloth.nodes.push_back(grid.node(i, j));
    }
  for (int j = 0; j < last; ++j)
    for (int i = 0; i < last; ++i)
      if (grid.has_cell(i, j)) add_cell(grid, i, j, cloth);
  add_lines(canopy, grid, rows.across.front(), cloth);
  return cloth;
}

} // namespace drogue::parachute
