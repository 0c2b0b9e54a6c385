// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/projection/surface_tree.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace drogue::projection {
namespace {

constexpr std::int32_t leaf_size = 4;
constexpr int stack_size = 64;
/// Curved elements bulge beyond the box of their nodes, by at most an eighth of its diagonal.
constexpr double bulge = 0.125;

} // namespace

SurfaceTree::SurfaceTree(const Elements& elements, std::span<const double> coordinates)
    : elements_(&elements), coordinates_(coordinates) {
  const std::int32_t n = elements.count();
  std::vector<Node> boxes(static_cast<std::size_t>(n));
  for (std::int32_t e = 0; e < n; ++e) {
    const auto nodes = elements.nodes(e);
    const NodeMatrix all = gather(nodes, coordinates);
    const auto X = all.leftCols(static_cast<Eigen::Index>(nodes.size()));
    Node& box = boxes[static_cast<std::size_t>(e)];
    box.low = X.rowwise().minCoeff();
    box.high = X.rowwise().maxCoeff();
    if (elements.kind(e) != mesh::ElementKind::tri3) {
      const double margin = bulge * (box.high - box.low).norm();
      box.low.array() -= margin;
      box.high.array() += margin;
    }
  }
  order_.resize(static_cast<std::size_t>(n));
  std::iota(order_.begin(), order_.end(), 0);
  if (n > 0) build(0, n, boxes);
}

std::int32_t SurfaceTree::build(std::int32_t first, std::int32_t last, std::span<const Node> boxes) {
  const auto box_of = [&](std::int32_t e) -> const Node& { return boxes[static_cast<std::size_t>(e)]; };
  Node node = box_of(order_[static_cast<std::size_t>(first)]);
  for (std::int32_t i = first; i < last; ++i) {
    const Node& box = box_of(order_[static_cast<std::size_t>(i)]);
    node.low = node.low.cwiseMin(box.low);
    node.high = node.high.cwiseMax(box.high);
  }
  node.first = first;
  node.count = last - first;
  const auto index = static_cast<std::int32_t>(nodes_.size());
  nodes_.push_back(node);
  if (node.count <= leaf_size) return index;

  Eigen::Index axis = 0;
  (node.high - node.low).maxCoeff(&axis);
  const std::int32_t middle = first + (last - first) / 2;
  const auto centre = [&](std::int32_t e) { return box_of(e).low[axis] + box_of(e).high[axis]; };
  std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                   [&](std::int32_t a, std::int32_t b) {
                     const double ca = centre(a), cb = centre(b);
                     return ca < cb || (ca == cb && a < b);
                   });
  build(first, middle, boxes);
  const std::int32_t right = build(middle, last, boxes);
  nodes_[static_cast<std::size_t>(index)].first = right;
  nodes_[static_cast<std::size_t>(index)].count = 0;
  return index;
}

double SurfaceTree::box_distance2(const Node& node, const Eigen::Vector3d& p) noexcept {
  const Eigen::Vector3d outside = (node.low - p).cwiseMax(p - node.high).cwiseMax(0.0);
  return outside.squaredNorm();
}

ClosestPoint SurfaceTree::on_element(std::int32_t e, const Eigen::Vector3d& p) const noexcept {
  const auto nodes = elements_->nodes(e);
  if (elements_->kind(e) != mesh::ElementKind::tri3)
    return closest_point(elements_->kind(e), gather(nodes, coordinates_), p);
  const auto corner = [&](std::size_t a) {
    return Eigen::Map<const Eigen::Vector3d>(coordinates_.data() + 3 * static_cast<std::size_t>(nodes[a]));
  };
  return closest_point_of_triangle(corner(0), corner(1), corner(2), p);
}

Located SurfaceTree::closest(const Eigen::Vector3d& p, std::int32_t hint) const noexcept {
  Located best;
  best.point.distance2 = std::numeric_limits<double>::infinity();
  const auto try_element = [&](std::int32_t e) {
    const ClosestPoint c = on_element(e, p);
    if (c.distance2 < best.point.distance2) best = {e, c};
  };
  if (hint >= 0) try_element(hint);

  std::array<std::pair<double, std::int32_t>, stack_size> stack;
  int top = 0;
  stack[top++] = {box_distance2(nodes_[0], p), 0};
  while (top > 0) {
    const auto [distance2, index] = stack[static_cast<std::size_t>(--top)];
    if (distance2 >= best.point.distance2) continue;
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (node.count > 0) {
      for (std::int32_t i = 0; i < node.count; ++i) {
        const std::int32_t e = order_[static_cast<std::size_t>(node.first + i)];
        if (e != hint) try_element(e);
      }
      continue;
    }
    std::pair<double, std::int32_t> near{box_distance2(nodes_[static_cast<std::size_t>(index) + 1], p),
                                         index + 1};
    std::pair<double, std::int32_t> far{box_distance2(nodes_[static_cast<std::size_t>(node.first)], p),
                                        node.first};
    if (far.first < near.first) std::swap(near, far);
    stack[static_cast<std::size_t>(top++)] = far;
    stack[static_cast<std::size_t>(top++)] = near;
  }
  return best;
}

int SurfaceTree::layers(const Eigen::Vector3d& p, double distance) const noexcept {
  int found = 0;
  std::array<std::int32_t, stack_size> stack;
  int top = 0;
  stack[top++] = 0;
  while (top > 0) {
    const std::int32_t index = stack[static_cast<std::size_t>(--top)];
    const Node& node = nodes_[static_cast<std::size_t>(index)];
    if (box_distance2(node, p) > distance * distance) continue;
    if (node.count == 0) {
      stack[static_cast<std::size_t>(top++)] = node.first;
      stack[static_cast<std::size_t>(top++)] = index + 1;
    }
    for (std::int32_t i = 0; i < node.count; ++i) {
      const std::int32_t e = order_[static_cast<std::size_t>(node.first + i)];
      const ClosestPoint c = on_element(e, p);
      if (c.inside && c.distance2 <= distance * distance) ++found;
    }
  }
  return found;
}

} // namespace drogue::projection
