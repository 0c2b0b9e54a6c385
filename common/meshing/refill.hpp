// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <limits>
#include <map>
#include <utility>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "common/meshing/disjoint_sets.hpp"
#include "common/meshing/remesh.hpp"
#include "common/meshing/simplex_locator.hpp"

/// What remeshing has in common in the plane (D = 2: triangles, facets are edges) and in space (D = 3).
namespace drogue::meshing::refill {

template <std::size_t D>
using Cell = std::array<std::int32_t, D + 1>;

template <std::size_t D>
struct Simplices {
  std::vector<Point> points;
  std::vector<Cell<D>> cells;
};

/// A cell's facet in a list that is sorted by the facet's nodes, so that equal ones stand next to each other.
template <std::size_t D>
struct FacetRecord {
  std::array<std::int32_t, D> key;
  std::int32_t cell = 0;
};
template <std::size_t D>
[[nodiscard]] std::vector<FacetRecord<D>> sorted_facets(const std::vector<Cell<D>>& cells) {
  std::vector<FacetRecord<D>> facets;
  facets.reserve((D + 1) * cells.size());
  for (std::size_t e = 0; e < cells.size(); ++e)
    for (std::size_t f = 0; f <= D; ++f) {
      FacetRecord<D>& facet = facets.emplace_back();
      facet.cell = static_cast<std::int32_t>(e);
      for (std::size_t a = 0, k = 0; a <= D; ++a)
        if (a != f) facet.key[k++] = cells[e][a];
      std::sort(facet.key.begin(), facet.key.end());
    }
  std::sort(facets.begin(), facets.end(), [](const FacetRecord<D>& a, const FacetRecord<D>& b) {
    return std::pair(a.key, a.cell) < std::pair(b.key, b.cell);
  });
  return facets;
}

/// Values of a nodal field of one component anywhere in the old mesh.
template <std::size_t D>
class Sizes {
 public:
  Sizes(const std::vector<Cell<D>>& cells, const SimplexLocator<D>& locator,
        const std::vector<double>& values)
      : cells_(cells),
        locator_(locator),
        values_(values),
        largest_(*std::max_element(values.begin(), values.end())) {}
  double operator()(const Point& x) {
    const SimplexPlace<D> place = locator_.find(x, last_);
    last_ = place.cell;
    if (place.cell < 0) return largest_;
    double size = 0, weights = 0;
    for (std::size_t a = 0; a <= D; ++a) {
      const double weight = std::max(0.0, place.weight[a]);
      const std::int32_t node = cells_[static_cast<std::size_t>(place.cell)][a];
      size += weight * values_[static_cast<std::size_t>(node)];
      weights += weight;
    }
    return size / weights;
  }

 private:
  const std::vector<Cell<D>>& cells_;
  const SimplexLocator<D>& locator_;
  const std::vector<double>& values_;
  double largest_;
  std::int32_t last_ = -1;
};

template <std::size_t D>
void mark_around(const Simplices<D>& m, const std::vector<char>& nodes, std::vector<char>& in) {
  for (std::size_t e = 0; e < m.cells.size(); ++e)
    if (std::any_of(m.cells[e].begin(), m.cells[e].end(),
                    [&](auto node) { return nodes[static_cast<std::size_t>(node)]; }))
      in[e] = 1;
}

/// Nodes around which the marked cells, or the others, do not hang together through facets.
template <std::size_t D>
std::vector<char> pinches(const Simplices<D>& m, const std::vector<FacetRecord<D>>& facets,
                          const std::vector<char>& in) {
  constexpr auto n = static_cast<std::int32_t>(D + 1);
  DisjointSets corners((D + 1) * m.cells.size());
  const auto corner = [&](std::int32_t e, std::int32_t node) {
    const Cell<D>& cell = m.cells[static_cast<std::size_t>(e)];
    return n * e + static_cast<std::int32_t>(std::find(cell.begin(), cell.end(), node) - cell.begin());
  };
  const auto is_in = [&](std::int32_t e) { return in[static_cast<std::size_t>(e)]; };
  for_equal_keys(facets, [&](auto first, auto last) {
    if (last - first == 2 && is_in(first->cell) == is_in((first + 1)->cell))
      for (const std::int32_t node : first->key)
        corners.unite(corner(first->cell, node), corner((first + 1)->cell, node));
  });
  std::vector<std::array<std::int32_t, 2>> regions(m.points.size());
  for (std::size_t e = 0; e < m.cells.size(); ++e)
    for (std::size_t c = 0; c <= D; ++c)
      if (const auto i = n * static_cast<std::int32_t>(e) + static_cast<std::int32_t>(c);
          corners.find(i) == i)
        ++regions[static_cast<std::size_t>(m.cells[e][c])][in[e] ? 1 : 0];
  std::vector<char> pinched(m.points.size(), 0);
  for (std::size_t i = 0; i < pinched.size(); ++i)
    pinched[i] = regions[i][1] > 0 && (regions[i][0] > 1 || regions[i][1] > 1);
  return pinched;
}

/// Cells with a worn node, and what else it takes for their outer facets not to touch each other elsewhere.
template <std::size_t D>
std::vector<char> worn_cells(const Simplices<D>& m, const mesh::NodeField& worn) {
  std::vector<char> nodes(m.points.size(), 0), in(m.cells.size(), 0);
  for (std::size_t i = 0; i < nodes.size(); ++i) nodes[i] = worn.values[i] > 0 ? 1 : 0;
  mark_around<D>(m, nodes, in);
  const auto facets = sorted_facets<D>(m.cells);
  for (auto before = std::ptrdiff_t{-1}, now = std::count(in.begin(), in.end(), 1); now > before;
       before = now, now = std::count(in.begin(), in.end(), 1))
    mark_around<D>(m, pinches<D>(m, facets, in), in);
  return in;
}

/// The marked cells, those that hang together through facets at a time.
template <std::size_t D>
std::vector<std::vector<Cell<D>>> cavities_of(const Simplices<D>& m, const std::vector<char>& in) {
  DisjointSets sets(m.cells.size());
  const auto is_in = [&](std::int32_t e) { return in[static_cast<std::size_t>(e)]; };
  for_equal_keys(sorted_facets<D>(m.cells), [&](auto first, auto last) {
    if (last - first == 2 && is_in(first->cell) && is_in((first + 1)->cell))
      sets.unite(first->cell, (first + 1)->cell);
  });
  std::map<std::int32_t, std::vector<Cell<D>>> cavities;
  for (std::size_t e = 0; e < m.cells.size(); ++e)
    if (in[e]) cavities[sets.find(static_cast<std::int32_t>(e))].push_back(m.cells[e]);
  std::vector<std::vector<Cell<D>>> result;
  for (auto& [representative, cells] : cavities) result.push_back(std::move(cells));
  return result;
}

/// A part of the domain filled anew: nodes that were there keep their numbers, new ones count from the number
/// that was asked for.
template <std::size_t D>
using Filling = Simplices<D>; ///< its points are the new ones

/// The mesh with some of its cells replaced, and where its nodes were.
template <std::size_t D>
struct Refilled {
  Simplices<D> mesh;
  std::vector<std::int32_t> previous; ///< {nodes}: old node; -1: a new one. Ascending, the new ones last
  std::vector<std::int32_t> number;   ///< of the old nodes and those made: where they are now; -1: gone
};

template <std::size_t D>
Refilled<D> numbered(const Simplices<D>& old, const std::vector<Point>& new_points,
                     std::vector<Cell<D>> cells) {
  Refilled<D> r;
  r.number.assign(old.points.size() + new_points.size(), -1);
  for (const Cell<D>& cell : cells)
    for (const std::int32_t node : cell) r.number[static_cast<std::size_t>(node)] = 0;
  for (std::size_t i = 0; i < r.number.size(); ++i) {
    if (r.number[i] < 0) continue;
    r.number[i] = static_cast<std::int32_t>(r.previous.size());
    const bool is_old = i < old.points.size();
    r.previous.push_back(is_old ? static_cast<std::int32_t>(i) : -1);
    r.mesh.points.push_back(is_old ? old.points[i] : new_points[i - old.points.size()]);
  }
  for (Cell<D>& cell : cells)
    for (std::int32_t& node : cell) node = r.number[static_cast<std::size_t>(node)];
  r.mesh.cells = std::move(cells);
  return r;
}

/// Replaces the marked cells: `fill(cells, first)` fills the place of some, `first` being the number of its
/// first new node.
template <std::size_t D, class Fill>
Result<Refilled<D>> replaced(const Simplices<D>& old, const std::vector<char>& in, Fill&& fill) {
  std::vector<Cell<D>> cells;
  for (std::size_t e = 0; e < old.cells.size(); ++e)
    if (!in[e]) cells.push_back(old.cells[e]);
  std::vector<Point> new_points;
  for (const std::vector<Cell<D>>& cavity : cavities_of<D>(old, in)) {
    const Result<Filling<D>> filling =
        fill(cavity, static_cast<std::int32_t>(old.points.size() + new_points.size()));
    if (!filling) return filling.error();
    new_points.insert(new_points.end(), filling->points.begin(), filling->points.end());
    cells.insert(cells.end(), filling->cells.begin(), filling->cells.end());
  }
  return numbered<D>(old, new_points, std::move(cells));
}

/// A nodal field of the old mesh on the new one: copied where nodes stay, interpolated elsewhere; NaN
/// outside.
template <std::size_t D>
mesh::NodeField carried(const mesh::NodeField& field, const Simplices<D>& old,
                        const SimplexLocator<D>& locator, const Refilled<D>& r) {
  const auto width = static_cast<std::size_t>(field.components);
  mesh::NodeField result{field.components, {}};
  result.values.reserve(width * r.previous.size());
  std::int32_t last = -1;
  for (std::size_t i = 0; i < r.previous.size(); ++i) {
    if (r.previous[i] >= 0) {
      const auto from = field.values.begin() + static_cast<std::ptrdiff_t>(width) * r.previous[i];
      result.values.insert(result.values.end(), from, from + static_cast<std::ptrdiff_t>(width));
      continue;
    }
    const SimplexPlace<D> place = locator.find(r.mesh.points[i], last);
    last = place.cell;
    for (std::size_t k = 0; k < width; ++k) {
      double value = place.cell < 0 ? std::numeric_limits<double>::quiet_NaN() : 0.0;
      for (std::size_t a = 0; a <= D && place.cell >= 0; ++a) {
        const std::int32_t node = old.cells[static_cast<std::size_t>(place.cell)][a];
        value += place.weight[a] * field.values[width * static_cast<std::size_t>(node) + k];
      }
      result.values.push_back(value);
    }
  }
  return result;
}

/// Fields of the old mesh, and those that remesh() adds, on the new one.
template <std::size_t D>
void carry_fields(const mesh::Mesh& from, const mesh::NodeField& size, const Simplices<D>& old,
                  const SimplexLocator<D>& locator, const Refilled<D>& r, mesh::Mesh& to) {
  for (const auto& [name, field] : from.node_fields)
    if (name != size_field_name && name != worn_field_name && name != previous_field_name)
      to.node_fields[name] = carried<D>(field, old, locator, r);
  to.node_fields[size_field_name] = carried<D>(size, old, locator, r);
  mesh::NodeField& previous = to.node_fields[previous_field_name];
  for (const std::int32_t node : r.previous)
    previous.values.push_back(node < 0 ? std::numeric_limits<double>::quiet_NaN() : node);
}

/// The new simplices of an old mesh, only those at worn nodes where these are given and that succeeds.
/// `refilled(marked)` replaces the marked cells.
template <std::size_t D, class Refill>
Result<Refilled<D>> refilled_where_worn(const mesh::Mesh& from, const Simplices<D>& old, Refill&& refilled) {
  const auto worn = from.node_fields.find(worn_field_name);
  const std::vector<char> all(old.cells.size(), 1);
  if (worn == from.node_fields.end()) return refilled(all);
  Result<Refilled<D>> made = refilled(worn_cells<D>(old, worn->second));
  return made ? std::move(made) : refilled(all);
}

/// The field "size" of the old mesh, or the sizes that it has.
[[nodiscard]] inline mesh::NodeField size_field(const mesh::Mesh& old) {
  const auto given = old.node_fields.find(size_field_name);
  return given != old.node_fields.end() ? given->second : sizes_of(old, old.points);
}

} // namespace drogue::meshing::refill
