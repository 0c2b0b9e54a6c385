// SPDX-License-Identifier: GPL-3.0-or-later
#include "surfaces.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace drogue::projection::test {
namespace {

void add(std::vector<double>& values, const Point& p) {
  for (const double v : p) values.push_back(v);
}

void add(Surface& s, const Point& p) {
  add(s.points, p);
}

Point point(const Surface& s, std::size_t i) {
  return {s.points[3 * i], s.points[3 * i + 1], s.points[3 * i + 2]};
}

Point on_sphere(const Point& p) {
  const double r = std::sqrt(p[0] * p[0] + p[1] * p[1] + p[2] * p[2]);
  return {p[0] / r, p[1] / r, p[2] / r};
}

Point bilinear(const Point& a, const Point& b, const Point& c, const Point& d, double s, double t) {
  Point p{};
  for (std::size_t k = 0; k < 3; ++k)
    p[k] = (1 - s) * (1 - t) * a[k] + s * (1 - t) * b[k] + s * t * c[k] + (1 - s) * t * d[k];
  return p;
}

Point corner(int q) {
  return {std::round(std::cos(q * std::numbers::pi / 2)), std::round(std::sin(q * std::numbers::pi / 2)), 0};
}

constexpr Point top{0, 0, 1};

Point middle(std::initializer_list<Point> points) {
  Point p{};
  for (const Point& q : points)
    for (std::size_t k = 0; k < 3; ++k) p[k] += q[k] / static_cast<double>(points.size());
  return p;
}

} // namespace

Surface grid(ElementKind kind, int n, const PointMap& map, bool other_diagonal) {
  const bool quadratic = kind == ElementKind::quad9 || kind == ElementKind::tri6;
  const int step = quadratic ? 2 : 1, m = step * n;
  Surface s;
  for (int j = 0; j <= m; ++j)
    for (int i = 0; i <= m; ++i) add(s, map(static_cast<double>(i) / m, static_cast<double>(j) / m));
  mesh::ElementBlock block{"surface", kind, {}};
  const auto at = [m](int i, int j) { return j * (m + 1) + i; };
  const auto triangle = [&](std::array<std::array<int, 2>, 3> c) {
    for (const auto& p : c) block.nodes.push_back(at(p[0], p[1]));
    for (std::size_t k = 0; quadratic && k < 3; ++k)
      block.nodes.push_back(at((c[k][0] + c[(k + 1) % 3][0]) / 2, (c[k][1] + c[(k + 1) % 3][1]) / 2));
  };
  for (int j = 0; j < m; j += step) {
    for (int i = 0; i < m; i += step) {
      const int I = i + step, J = j + step;
      if (kind == ElementKind::quad4)
        block.nodes.insert(block.nodes.end(), {at(i, j), at(I, j), at(I, J), at(i, J)});
      else if (kind == ElementKind::quad9)
        block.nodes.insert(block.nodes.end(), {at(i, j), at(I, j), at(I, J), at(i, J), at(i + 1, j),
                                               at(I, j + 1), at(i + 1, J), at(i, j + 1), at(i + 1, j + 1)});
      else if (other_diagonal) {
        triangle({{{i, j}, {I, j}, {i, J}}});
        triangle({{{I, j}, {I, J}, {i, J}}});
      } else {
        triangle({{{i, j}, {I, j}, {I, J}}});
        triangle({{{i, j}, {I, J}, {i, J}}});
      }
    }
  }
  s.blocks.push_back(std::move(block));
  return s;
}

Surface plate(ElementKind kind, int n, bool other_diagonal) {
  return grid(
      kind, n,
      [](double x, double y) {
        return Point{x, y, 0};
      },
      other_diagonal);
}

Surface chain(ElementKind kind, int n, const std::function<Point(double)>& map) {
  const int step = kind == ElementKind::line3 ? 2 : 1, m = step * n;
  Surface s;
  for (int i = 0; i <= m; ++i) add(s, map(static_cast<double>(i) / m));
  mesh::ElementBlock block{"surface", kind, {}};
  for (int i = 0; i < m; i += step) {
    block.nodes.insert(block.nodes.end(), {i, i + step});
    if (step == 2) block.nodes.push_back(i + 1);
  }
  s.blocks.push_back(std::move(block));
  return s;
}

Surface interval(ElementKind kind, int n) {
  return chain(kind, n, [](double s) { return Point{s, 0, 0}; });
}

Surface lat_long_hemisphere(int m) {
  Surface s;
  add(s, top);
  const int k = 4 * m;
  for (int i = 1; i <= m; ++i) {
    for (int j = 0; j < k; ++j) {
      const double theta = i * std::numbers::pi / (2 * m),
                   phi = 2 * std::numbers::pi * (j + 0.5 * (i % 2)) / k;
      add(s, {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)});
    }
  }
  mesh::ElementBlock block{"surface", ElementKind::tri3, {}};
  const auto at = [k](int i, int j) { return 1 + (i - 1) * k + (j + k) % k; };
  for (int j = 0; j < k; ++j) block.nodes.insert(block.nodes.end(), {0, at(1, j), at(1, j + 1)});
  for (int i = 1; i < m; ++i) {
    for (int j = 0; j < k; ++j) {
      const int o = i % 2; // the upper ring is ahead by half a spacing when o is 1
      block.nodes.insert(block.nodes.end(), {at(i, j), at(i + 1, j + o), at(i, j + 1)});
      block.nodes.insert(block.nodes.end(), {at(i + 1, j + o - 1), at(i + 1, j + o), at(i, j)});
    }
  }
  s.blocks.push_back(std::move(block));
  return s;
}

Surface octahedron_hemisphere(int n) {
  Surface all;
  for (int q = 0; q < 4; ++q) {
    Surface s;
    std::vector<std::vector<int>> number(static_cast<std::size_t>(n) + 1);
    for (int r = 0; r <= n; ++r) {
      for (int t = 0; t <= r; ++t) {
        Point p{};
        for (std::size_t k = 0; k < 3; ++k)
          p[k] = ((r - t) * corner(q)[k] + t * corner(q + 1)[k] + (n - r) * top[k]) / n;
        number[static_cast<std::size_t>(r)].push_back(static_cast<int>(s.node_count()));
        add(s, on_sphere(p));
      }
    }
    const auto at = [&](int r, int t) {
      return number[static_cast<std::size_t>(r)][static_cast<std::size_t>(t)];
    };
    mesh::ElementBlock block{"surface", ElementKind::tri3, {}};
    for (int r = 0; r < n; ++r) {
      for (int t = 0; t <= r; ++t) {
        block.nodes.insert(block.nodes.end(), {at(r, t), at(r + 1, t), at(r + 1, t + 1)});
        if (t < r) block.nodes.insert(block.nodes.end(), {at(r, t), at(r + 1, t + 1), at(r, t + 1)});
      }
    }
    s.blocks.push_back(std::move(block));
    all = combine_surfaces(all, s);
  }
  return weld(all);
}

Surface quad9_hemisphere(int n) {
  Surface all;
  for (int q = 0; q < 4; ++q) {
    const Point v[] = {corner(q), corner(q + 1), top};
    const Point centre = middle({v[0], v[1], v[2]});
    for (std::size_t c = 0; c < 3; ++c) {
      const Point ahead = middle({v[c], v[(c + 1) % 3]}), behind = middle({v[c], v[(c + 2) % 3]});
      all = combine_surfaces(all, grid(ElementKind::quad9, n, [&](double x, double y) {
                               return on_sphere(bilinear(v[c], ahead, centre, behind, x, y));
                             }));
    }
  }
  return weld(all);
}

Surface sphere(int n) {
  const Surface upper = octahedron_hemisphere(n);
  Surface lower = upper;
  for (std::size_t i = 2; i < lower.points.size(); i += 3) lower.points[i] *= -1;
  turn_over(lower);
  return weld(combine_surfaces(upper, lower));
}

Surface disc(ElementKind kind, int n) {
  return grid(kind, n, [](double s, double t) { // concentric squares to concentric circles
    const double x = 2 * s - 1, y = 2 * t - 1;
    return Point{x * std::sqrt(1 - y * y / 2), y * std::sqrt(1 - x * x / 2), 0};
  });
}

Surface two_sided_disc(int n) {
  Surface s = disc(ElementKind::tri3, n);
  const std::size_t nodes = s.node_count();
  std::vector<std::int32_t> twin(nodes);
  for (std::size_t i = 0; i < nodes; ++i) {
    const Point p = point(s, i);
    const bool rim = std::hypot(p[0], p[1]) > 1 - 1e-12;
    twin[i] = static_cast<std::int32_t>(rim ? i : s.node_count());
    if (!rim) add(s, p);
  }
  mesh::ElementBlock lower = s.blocks[0];
  for (std::size_t k = 0; k < lower.nodes.size(); k += 3) std::swap(lower.nodes[k + 1], lower.nodes[k + 2]);
  for (std::int32_t& node : lower.nodes) node = twin[static_cast<std::size_t>(node)];
  s.blocks.push_back(std::move(lower));
  return s;
}

std::vector<std::int32_t> other_side(const Surface& s) {
  std::vector<std::int32_t> twin(s.node_count());
  const auto& a = s.blocks[0].nodes;
  const auto& b = s.blocks[1].nodes;
  for (std::size_t k = 0; k < a.size(); k += 3) {
    constexpr std::size_t back[] = {0, 2, 1};
    for (std::size_t c = 0; c < 3; ++c) {
      twin[static_cast<std::size_t>(a[k + c])] = b[k + back[c]];
      twin[static_cast<std::size_t>(b[k + back[c]])] = a[k + c];
    }
  }
  return twin;
}

Surface combine_surfaces(const Surface& a, const Surface& b) {
  Surface s = a;
  const auto shift = static_cast<std::int32_t>(a.node_count());
  for (const double x : b.points) s.points.push_back(x);
  for (mesh::ElementBlock block : b.blocks) {
    for (std::int32_t& node : block.nodes) node += shift;
    s.blocks.push_back(std::move(block));
  }
  return s;
}

Surface weld(const Surface& surface) {
  const Merged merged = merge_coincident(surface.points, 1e-9);
  Surface s;
  s.points.resize(3 * static_cast<std::size_t>(merged.count));
  for (std::size_t i = 0; i < surface.node_count(); ++i)
    for (std::size_t k = 0; k < 3; ++k)
      s.points[3 * static_cast<std::size_t>(merged.group[i]) + k] = surface.points[3 * i + k];
  for (mesh::ElementBlock block : surface.blocks) {
    for (std::int32_t& node : block.nodes) node = merged.group[static_cast<std::size_t>(node)];
    s.blocks.push_back(std::move(block));
  }
  return s;
}

void turn_over(Surface& surface) {
  for (mesh::ElementBlock& block : surface.blocks)
    for (std::size_t k = 0; k < block.nodes.size(); k += 3) std::swap(block.nodes[k + 1], block.nodes[k + 2]);
}

std::vector<double> sample(const Surface& surface, const std::function<Point(const Point&)>& f) {
  std::vector<double> values;
  for (std::size_t i = 0; i < surface.node_count(); ++i) add(values, f(point(surface, i)));
  return values;
}

Point wavy(const Point& p) {
  const auto f = [](double x, double y, double z) { return std::sin(4 * x) * std::cos(3 * y) + z; };
  return {f(p[0], p[1], p[2]), f(p[1], p[2], p[0]), f(p[2], p[0], p[1])};
}

double relative_error(const std::vector<double>& a, const std::vector<double>& b) {
  double difference = 0, size = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    difference += (a[i] - b[i]) * (a[i] - b[i]);
    size += b[i] * b[i];
  }
  return std::sqrt(difference / size);
}

double largest_difference(const std::vector<double>& a, const std::vector<double>& b) {
  if (a.size() != b.size()) return std::numeric_limits<double>::infinity();
  double largest = 0;
  for (std::size_t i = 0; i < a.size(); ++i) largest = std::max(largest, std::abs(a[i] - b[i]));
  return largest;
}

} // namespace drogue::projection::test
