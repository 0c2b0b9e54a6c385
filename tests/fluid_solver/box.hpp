// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "common/mesh/mesh.hpp"
#include "fluid_solver/settings.hpp"

/// Boxes of tetrahedra and settings for the tests of the flow solver.
namespace drogue::fluid::test {

/// A box [0, size] of n[0] x n[1] x n[2] cells, six tetrahedra each; boundaries x0 x1 y0 y1 z0 z1.
/// mirrored: every other cell is the mirror image of its neighbour, so that the triangles round a node are
/// symmetric.
inline mesh::Mesh box_mesh(std::array<int, 3> n, std::array<double, 3> size, bool mirrored = false) {
  mesh::Mesh m;
  const auto flipped = [&](int cell) { return mirrored && cell % 2 == 1; };
  const auto id = [&](int i, int j, int k) { return (k * (n[1] + 1) + j) * (n[0] + 1) + i; };
  for (int k = 0; k <= n[2]; ++k)
    for (int j = 0; j <= n[1]; ++j)
      for (int i = 0; i <= n[0]; ++i) {
        m.points.push_back(size[0] * i / n[0]);
        m.points.push_back(size[1] * j / n[1]);
        m.points.push_back(size[2] * k / n[2]);
      }
  mesh::ElementBlock fluid{"fluid", mesh::ElementKind::tet4, {}};
  constexpr int order[6][3] = {{0, 1, 2}, {0, 2, 1}, {1, 0, 2}, {1, 2, 0}, {2, 0, 1}, {2, 1, 0}};
  for (int k = 0; k < n[2]; ++k)
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        for (const auto& path : order) {
          int at[3] = {i + flipped(i), j + flipped(j), k + flipped(k)};
          const int step[3] = {flipped(i) ? -1 : 1, flipped(j) ? -1 : 1, flipped(k) ? -1 : 1};
          fluid.nodes.push_back(id(at[0], at[1], at[2]));
          for (const int axis : path) {
            at[axis] += step[axis];
            fluid.nodes.push_back(id(at[0], at[1], at[2]));
          }
        }
  m.blocks.push_back(fluid);
  for (int axis = 0; axis < 3; ++axis)
    for (int side = 0; side < 2; ++side) {
      mesh::ElementBlock block{std::string(1, static_cast<char>('x' + axis)) + static_cast<char>('0' + side),
                               mesh::ElementKind::tri3,
                               {}};
      const int p = (axis + 1) % 3;
      const int q = (axis + 2) % 3;
      for (int a = 0; a < n[static_cast<std::size_t>(p)]; ++a)
        for (int b = 0; b < n[static_cast<std::size_t>(q)]; ++b) {
          const auto node = [&](int da, int db) {
            int at[3];
            at[axis] = side * n[static_cast<std::size_t>(axis)];
            at[p] = a + (flipped(a) ? 1 - da : da);
            at[q] = b + (flipped(b) ? 1 - db : db);
            return id(at[0], at[1], at[2]);
          };
          for (const int v : {node(0, 0), node(1, 0), node(1, 1), node(0, 0), node(1, 1), node(0, 1)})
            block.nodes.push_back(v);
        }
      m.blocks.push_back(block);
    }
  return m;
}

/// The same in two dimensions: [0, size] of n[0] x n[1] cells of two triangles; boundaries x0 x1 y0 y1. All
/// diagonals run the same way, or with `crossed` in turn.
inline mesh::Mesh rectangle_mesh(std::array<int, 2> n, std::array<double, 2> size, bool crossed = false) {
  mesh::Mesh m;
  const auto id = [&](int i, int j) { return j * (n[0] + 1) + i; };
  for (int j = 0; j <= n[1]; ++j)
    for (int i = 0; i <= n[0]; ++i)
      m.points.insert(m.points.end(), {size[0] * i / n[0], size[1] * j / n[1], 0.0});
  mesh::ElementBlock fluid{"fluid", mesh::ElementKind::tri3, {}};
  for (int j = 0; j < n[1]; ++j)
    for (int i = 0; i < n[0]; ++i) {
      const int a = id(i, j);
      const int b = id(i + 1, j);
      const int c = id(i + 1, j + 1);
      const int d = id(i, j + 1);
      if (crossed && (i + j) % 2 == 1)
        fluid.nodes.insert(fluid.nodes.end(), {a, b, d, b, c, d});
      else
        fluid.nodes.insert(fluid.nodes.end(), {a, b, c, a, c, d});
    }
  m.blocks.push_back(fluid);
  mesh::ElementBlock sides[4] = {{"x0", mesh::ElementKind::line2, {}},
                                 {"x1", mesh::ElementKind::line2, {}},
                                 {"y0", mesh::ElementKind::line2, {}},
                                 {"y1", mesh::ElementKind::line2, {}}};
  for (int j = 0; j < n[1]; ++j) {
    sides[0].nodes.insert(sides[0].nodes.end(), {id(0, j), id(0, j + 1)});
    sides[1].nodes.insert(sides[1].nodes.end(), {id(n[0], j), id(n[0], j + 1)});
  }
  for (int i = 0; i < n[0]; ++i) {
    sides[2].nodes.insert(sides[2].nodes.end(), {id(i, 0), id(i + 1, 0)});
    sides[3].nodes.insert(sides[3].nodes.end(), {id(i, n[1]), id(i + 1, n[1])});
  }
  for (const auto& side : sides) m.blocks.push_back(side);
  return m;
}

inline config::VectorExpression vector_expression(const std::string& x, const std::string& y,
                                                  const std::string& z) {
  return {config::Expression::parse(x).value(), config::Expression::parse(y).value(),
          config::Expression::parse(z).value()};
}

inline BoundarySettings boundary(std::string name, Condition condition) {
  BoundarySettings b;
  b.name = std::move(name);
  b.condition = condition;
  return b;
}

inline BoundarySettings velocity(std::string name, const std::string& x, const std::string& y,
                                 const std::string& z) {
  BoundarySettings b = boundary(std::move(name), Condition::velocity);
  b.value = vector_expression(x, y, z);
  return b;
}

/// Density 2, viscosity as given, tight tolerances, no boundary conditions yet.
inline Settings tight_settings(double dynamic_viscosity) {
  Settings s;
  s.mesh = "box.msh";
  s.linear_method = LinearMethod::krylov;
  s.density = 2;
  s.dynamic_viscosity = dynamic_viscosity;
  s.newton = {1e-13, 30, 0.5, 1, 1};
  s.linear = {1e-6, 400, 100};
  return s;
}

/// Velocity given by the same expressions on all six sides.
inline void velocity_all_around(Settings& s, const std::string& x, const std::string& y,
                                const std::string& z) {
  for (const char* name : {"x0", "x1", "y0", "y1", "z0", "z1"})
    s.boundaries.push_back(velocity(name, x, y, z));
}

/// On the four sides of a rectangle.
inline void velocity_all_around(Settings& s, const std::string& x, const std::string& y) {
  for (const char* name : {"x0", "x1", "y0", "y1"}) s.boundaries.push_back(velocity(name, x, y, "0"));
}

/// Every coordinate (in two dimensions: x and y) moved at random by at most `amount`.
inline std::vector<double> shaken(std::vector<double> points, double amount, unsigned seed,
                                  int dimension = 3) {
  std::mt19937 generator(seed);
  std::uniform_real_distribution<double> uniform(-amount, amount);
  for (std::size_t i = 0; i < points.size(); ++i)
    if (i % 3 < static_cast<std::size_t>(dimension)) points[i] += uniform(generator);
  return points;
}

} // namespace drogue::fluid::test
