// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

namespace drogue::projection {
namespace {

/// How far lines may lie outside their plane, relative to their size.
constexpr double flatness = 1e-9;

using Cell = std::array<std::int64_t, 3>;

/// The nodes in each cell of a grid, by open addressing.
class CellTable {
 public:
  explicit CellTable(std::size_t nodes) : next_(nodes, -1) {
    std::size_t slots = 16;
    while (slots < 2 * nodes) slots *= 2;
    slots_.resize(slots);
  }
  [[nodiscard]] std::int32_t first(const Cell& c) const { return slots_[find(c)].node; }
  [[nodiscard]] std::int32_t next(std::int32_t node) const { return next_[static_cast<std::size_t>(node)]; }
  /// Behind the nodes that the cell has already.
  void add(const Cell& c, std::int32_t node) {
    Slot& slot = slots_[find(c)];
    if (slot.node < 0)
      slot = {c, node, node};
    else
      next_[static_cast<std::size_t>(std::exchange(slot.last, node))] = node;
  }

 private:
  struct Slot {
    Cell cell{};
    std::int32_t node = -1, last = -1;
  };
  [[nodiscard]] std::size_t find(const Cell& c) const {
    std::uint64_t h = 1469598103934665603ULL;
    for (const std::int64_t i : c)
      h = (h ^ static_cast<std::uint64_t>(i)) * 0x9E3779B97F4A7C15ULL, h ^= h >> 29;
    std::size_t at = h & (slots_.size() - 1);
    while (slots_[at].node >= 0 && slots_[at].cell != c) at = (at + 1) & (slots_.size() - 1);
    return at;
  }

  std::vector<Slot> slots_;
  std::vector<std::int32_t> next_;
};

Result<void> check_coordinates(const Surface& s, const std::vector<double>& values, const char* what) {
  if (values.size() != s.points.size())
    return config_error("the {} surface has {} {} values for {} nodes", s.name, values.size(), what,
                        s.node_count());
  for (std::size_t i = 0; i < values.size(); ++i)
    if (!std::isfinite(values[i]))
      return config_error("the {} surface: {} coordinate {} of node {} is not finite", s.name, what, i % 3,
                          i / 3);
  return {};
}

Result<void> check_connectivity(const Surface& s) {
  std::vector<char> used(s.node_count(), 0);
  for (const mesh::ElementBlock& block : s.blocks) {
    const int dimension = mesh::dimension(block.kind);
    if (dimension != 1 && dimension != 2)
      return config_error(
          "the {} surface holds {} elements; a surface is made of triangles and quadrilaterals, in a plane "
          "problem of lines",
          s.name, mesh::name(block.kind));
    if (dimension != s.dimension())
      return config_error("the {} surface holds {} and {} elements; it must be made of faces or of lines",
                          s.name, mesh::name(s.blocks.front().kind), mesh::name(block.kind));
    if (block.nodes.size() % static_cast<std::size_t>(mesh::nodes_per_element(block.kind)) != 0)
      return config_error("the {} surface: {} indices are no whole number of {} elements", s.name,
                          block.nodes.size(), mesh::name(block.kind));
    for (const std::int32_t node : block.nodes) {
      if (node < 0 || static_cast<std::size_t>(node) >= s.node_count())
        return config_error("the {} surface: an element names node {} of {}", s.name, node, s.node_count());
      used[static_cast<std::size_t>(node)] = 1;
    }
  }
  const auto unused = std::find(used.begin(), used.end(), 0);
  if (unused != used.end())
    return config_error("the {} surface: node {} belongs to no element", s.name, unused - used.begin());
  return {};
}

/// Lines have a normal in a plane z = const alone.
Result<void> check_plane(const Surface& s, const std::vector<double>& coordinates, const char* what) {
  if (s.dimension() != 1) return {};
  const double size = extent(coordinates);
  for (std::size_t i = 2; i < coordinates.size(); i += 3)
    if (std::abs(coordinates[i] - coordinates[2]) > flatness * size)
      return config_error(
          "the {} surface is made of lines, but its node {} lies outside the plane z = {:.6g} of node 0 "
          "in {} coordinates (z = {:.6g})",
          s.name, i / 3, coordinates[2], what, coordinates[i]);
  return {};
}

Result<void> check_areas(const Surface& s, const std::vector<double>& coordinates, const char* what) {
  const Elements elements(s);
  const double least = std::pow(1e-10 * extent(coordinates), s.dimension());
  for (std::int32_t e = 0; e < elements.count(); ++e)
    if (!(rough_area(elements.kind(e), gather(elements.nodes(e), coordinates)) > least))
      return config_error("the {} surface: element {} has no area in {} coordinates", s.name, e, what);
  return {};
}

} // namespace

Elements::Elements(const Surface& surface) {
  for (const mesh::ElementBlock& block : surface.blocks) {
    for (std::int32_t e = 0; e < block.count(); ++e) {
      kinds_.push_back(block.kind);
      const auto nodes = block.element(e);
      nodes_.insert(nodes_.end(), nodes.begin(), nodes.end());
      offsets_.push_back(static_cast<std::int64_t>(nodes_.size()));
    }
  }
}

Result<void> complete(Surface& s) {
  if (s.reference.empty()) s.reference = s.points;
  if (s.material.empty()) s.material = s.reference;
  if (s.points.empty() || s.points.size() % 3 != 0 || Elements(s).count() == 0)
    return config_error("the {} surface is empty", s.name);
  DROGUE_TRY(check_coordinates(s, s.points, "position"));
  DROGUE_TRY(check_coordinates(s, s.reference, "reference"));
  DROGUE_TRY(check_coordinates(s, s.material, "material"));
  DROGUE_TRY(check_connectivity(s));
  DROGUE_TRY(check_plane(s, s.points, "starting"));
  DROGUE_TRY(check_plane(s, s.reference, "reference"));
  DROGUE_TRY(check_plane(s, s.material, "material"));
  DROGUE_TRY(check_areas(s, s.reference, "reference"));
  return check_areas(s, s.material, "material");
}

double extent(std::span<const double> coordinates) noexcept {
  double square = 0;
  for (std::size_t k = 0; k < 3; ++k) {
    double low = coordinates[k], high = coordinates[k];
    for (std::size_t i = k; i < coordinates.size(); i += 3) {
      low = std::min(low, coordinates[i]);
      high = std::max(high, coordinates[i]);
    }
    square += (high - low) * (high - low);
  }
  return std::sqrt(square);
}

Merged merge_coincident(std::span<const double> x, double tolerance) {
  // Cells much wider than the tolerance: hardly a node lies so near to a cell's border that it must look
  // beyond.
  const double width = 4096 * tolerance;
  CellTable cells(x.size() / 3);
  Merged merged;
  merged.group.reserve(x.size() / 3);
  const auto near = [&](std::size_t i, std::size_t j) {
    double square = 0;
    for (std::size_t k = 0; k < 3; ++k)
      square += (x[3 * i + k] - x[3 * j + k]) * (x[3 * i + k] - x[3 * j + k]);
    return square <= tolerance * tolerance;
  };
  for (std::size_t i = 0; i < x.size() / 3; ++i) {
    Cell cell, low, high;
    for (std::size_t k = 0; k < 3; ++k) {
      cell[k] = static_cast<std::int64_t>(std::floor(x[3 * i + k] / width));
      low[k] = static_cast<std::int64_t>(std::floor((x[3 * i + k] - tolerance) / width));
      high[k] = static_cast<std::int64_t>(std::floor((x[3 * i + k] + tolerance) / width));
    }
    std::int32_t group = -1;
    Cell c = low;
    for (c[0] = low[0]; c[0] <= high[0] && group < 0; ++c[0])
      for (c[1] = low[1]; c[1] <= high[1] && group < 0; ++c[1])
        for (c[2] = low[2]; c[2] <= high[2] && group < 0; ++c[2])
          for (std::int32_t j = cells.first(c); j >= 0 && group < 0; j = cells.next(j))
            if (near(i, static_cast<std::size_t>(j))) group = merged.group[static_cast<std::size_t>(j)];
    if (group < 0) {
      cells.add(cell, static_cast<std::int32_t>(i));
      group = merged.count++;
    }
    merged.group.push_back(group);
  }
  return merged;
}

} // namespace drogue::projection
