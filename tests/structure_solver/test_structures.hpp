// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cmath>
#include <cstdint>
#include <functional>
#include <numbers>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Dense>
#include <gtest/gtest.h>

#include "common/mesh/mesh.hpp"
#include "structure_solver/integrator.hpp"
#include "structure_solver/model.hpp"
#include "tests/structure_solver/test_meshes.hpp"

/// Small meshes and models built in memory.
namespace drogue::structure::test {

/// A repeatable sequence of numbers in [-1, 1).
class Numbers {
 public:
  double operator()() {
    state_ = state_ * 6364136223846793005ULL + 1442695040888963407ULL;
    return static_cast<double>(state_ >> 11) * 0x1.0p-52 - 1;
  }

 private:
  std::uint64_t state_ = 42;
};

inline config::Expression expression(const std::string& text) {
  auto parsed = config::Expression::parse(text);
  EXPECT_TRUE(parsed) << text;
  return std::move(*parsed);
}
inline config::VectorExpression vector(const std::string& x, const std::string& y, const std::string& z) {
  return {expression(x), expression(y), expression(z)};
}

/// Regular grid of m x n Q9 elements, or what fills their place (two T6, four Q4, eight T3), on [0, 1]^2
/// mapped by `map`. Groups: "cloth", and the points "edge" along the boundary.
using Map = std::function<Eigen::Vector3d(double, double)>;
inline mesh::Mesh sheet(mesh::ElementKind kind, int m, int n, const Map& map) {
  mesh::Mesh mesh;
  const int rows = 2 * n + 1, columns = 2 * m + 1;
  const auto id = [columns](int i, int j) { return static_cast<std::int32_t>(j * columns + i); };
  mesh::ElementBlock edge{"edge", mesh::ElementKind::point1, {}}, cloth{"cloth", kind, {}};
  for (int j = 0; j < rows; ++j)
    for (int i = 0; i < columns; ++i) {
      const Eigen::Vector3d X = map(static_cast<double>(i) / (2 * m), static_cast<double>(j) / (2 * n));
      mesh.points.insert(mesh.points.end(), {X(0), X(1), X(2)});
      if (i == 0 || j == 0 || i == columns - 1 || j == rows - 1) edge.nodes.push_back(id(i, j));
    }
  for (int j = 0; j < rows - 1; j += 2)
    for (int i = 0; i < columns - 1; i += 2) {
      std::array<std::array<std::int32_t, 3>, 3> patch{};
      for (int b = 0; b < 3; ++b)
        for (int a = 0; a < 3; ++a)
          patch[static_cast<std::size_t>(b)][static_cast<std::size_t>(a)] = id(i + a, j + b);
      fill_patch(cloth, patch);
    }
  mesh.blocks = {std::move(cloth), std::move(edge)};
  return mesh;
}

/// A chain of `elements` two-node lines from `from` to `to`. Groups: "line", points "first", "last",
/// "middle".
inline mesh::Mesh chain(int elements, const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  mesh::Mesh mesh;
  mesh::ElementBlock line{"line", mesh::ElementKind::line2, {}};
  for (int i = 0; i <= elements; ++i) {
    const Eigen::Vector3d X = from + (to - from) * i / elements;
    mesh.points.insert(mesh.points.end(), {X(0), X(1), X(2)});
    if (i > 0) line.nodes.insert(line.nodes.end(), {i - 1, i});
  }
  const auto point = [](const char* group, int node) {
    return mesh::ElementBlock{group, mesh::ElementKind::point1, {node}};
  };
  mesh.blocks = {std::move(line), point("first", 0), point("last", elements), point("middle", elements / 2)};
  return mesh;
}

/// Builds a model and expects it to be free of errors.
inline Model model(const Settings& settings, mesh::Mesh mesh) {
  config::Report report;
  auto built = build_model(settings, std::move(mesh), report);
  for (const auto& line : report.lines()) ADD_FAILURE() << line;
  return built ? std::move(*built) : Model{};
}

/// Static equilibrium from a state by damped dynamics at a fixed step; the integrator ends in that state.
inline void settle(Integrator& integrator, double dt, int steps) {
  for (int k = 0; k < steps; ++k) {
    integrator.begin_step(dt, Integrator::Predictor::hold);
    const auto outcome = integrator.iterate_to_tolerance();
    ASSERT_TRUE(outcome) << outcome.error().message;
    ASSERT_TRUE(outcome->converged) << "step " << k << ", correction " << outcome->correction;
    integrator.commit();
  }
}

} // namespace drogue::structure::test
