// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <Eigen/Dense>

#include "common/la_direct/direct_solver.hpp"
#include "tests/structure_solver/test_structures.hpp"

/// Meshes put together from mapped squares, and natural frequencies.
namespace drogue::structure::test {

/// Surface "cloth" of Q9 or T3 joined from squares; nodes at the same place are one node.
class PatchWork {
 public:
  explicit PatchWork(mesh::ElementKind kind) : cloth_{"cloth", kind, {}} {}

  /// m x n elements Q9 (each split into eight T3) on the image of the unit square.
  void add(int m, int n, const Map& map) {
    const mesh::Mesh patch = sheet(cloth_.kind, m, n, map);
    std::vector<std::int32_t> ids;
    for (std::int32_t i = 0; i < patch.node_count(); ++i)
      ids.push_back(node(&patch.points[3 * static_cast<std::size_t>(i)]));
    for (const std::int32_t i : patch.blocks[0].nodes)
      cloth_.nodes.push_back(ids[static_cast<std::size_t>(i)]);
  }

  /// A group of the nodes where `in` holds.
  void group(const std::string& name, const std::function<bool(const Eigen::Vector3d&)>& in) {
    mesh::ElementBlock block{name, mesh::ElementKind::point1, {}};
    for (std::int32_t i = 0; i < mesh_.node_count(); ++i)
      if (in(Eigen::Map<const Eigen::Vector3d>(&mesh_.points[3 * static_cast<std::size_t>(i)])))
        block.nodes.push_back(i);
    mesh_.blocks.push_back(std::move(block));
  }

  [[nodiscard]] mesh::Mesh mesh() const {
    mesh::Mesh m = mesh_;
    m.blocks.insert(m.blocks.begin(), cloth_);
    return m;
  }

 private:
  std::int32_t node(const double* x) {
    std::array<long, 3> key{};
    for (std::size_t c = 0; c < 3; ++c) key[c] = std::lround(x[c] * 1e8);
    const auto [at, fresh] = known_.try_emplace(key, mesh_.node_count());
    if (fresh) mesh_.points.insert(mesh_.points.end(), x, x + 3);
    return at->second;
  }

  mesh::Mesh mesh_;
  mesh::ElementBlock cloth_;
  std::map<std::array<long, 3>, std::int32_t> known_;
};

/// Unit disk of Q9: a square of m x m with bulging sides in the middle, and k rows around it. Points "edge".
inline mesh::Mesh quad_disk(int m, int k) {
  PatchWork work(mesh::ElementKind::quad9);
  const double inner = 0.5, bulge = 0.6; // half diagonal share; 1: a circle, 0: a square
  const auto side = [=](double s) {      // the square's lower side, from corner to corner
    const double angle = std::numbers::pi * (-0.75 + 0.5 * s);
    const Eigen::Vector3d arc(inner * std::cos(angle), inner * std::sin(angle), 0);
    const double corner = inner / std::numbers::sqrt2;
    const Eigen::Vector3d straight(corner * (2 * s - 1), -corner, 0);
    return Eigen::Vector3d(bulge * arc + (1 - bulge) * straight);
  };
  const auto turned = [](int quarter, const Eigen::Vector3d& x) {
    return Eigen::Vector3d(Eigen::AngleAxisd(0.5 * std::numbers::pi * quarter, Eigen::Vector3d::UnitZ()) * x);
  };
  work.add(m, m, [&](double s, double t) { // Coons patch of the four sides
    const Eigen::Vector3d bottom = side(s), top = turned(2, side(1 - s));
    const Eigen::Vector3d right = turned(1, side(t)), left = turned(3, side(1 - t));
    const Eigen::Vector3d corners = (1 - s) * (1 - t) * side(0) + s * (1 - t) * side(1) +
                                    s * t * turned(2, side(0)) + (1 - s) * t * turned(2, side(1));
    return Eigen::Vector3d((1 - t) * bottom + t * top + (1 - s) * left + s * right - corners);
  });
  for (int quarter = 0; quarter < 4; ++quarter)
    work.add(m, k, [&](double s, double t) {
      const double angle = std::numbers::pi * (-0.75 + 0.5 * s);
      const Eigen::Vector3d rim(std::cos(angle), std::sin(angle), 0);
      // t runs inwards, so that the normal points up
      return turned(quarter, t * side(s) + (1 - t) * rim);
    });
  work.group("edge", [](const Eigen::Vector3d& X) { return X.norm() > 1 - 1e-6; });
  return work.mesh();
}

/// Unit disk of T3: ring k has 6 k edges around. Points "edge".
inline mesh::Mesh triangle_disk(int rings) {
  mesh::Mesh mesh;
  mesh.points = {0, 0, 0};
  std::vector<std::int32_t> first{0};
  mesh::ElementBlock cloth{"cloth", mesh::ElementKind::tri3, {}}, edge{"edge", mesh::ElementKind::point1, {}};
  for (int k = 1; k <= rings; ++k) {
    first.push_back(mesh.node_count());
    for (int j = 0; j < 6 * k; ++j) {
      const double angle = 2 * std::numbers::pi * j / (6 * k), r = static_cast<double>(k) / rings;
      if (k == rings) edge.nodes.push_back(mesh.node_count());
      mesh.points.insert(mesh.points.end(), {r * std::cos(angle), r * std::sin(angle), 0});
    }
  }
  for (int k = 1; k <= rings; ++k)
    for (int sector = 0; sector < 6; ++sector)
      for (int j = 0; j < k; ++j) {
        const auto outer = [&](int i) {
          return first[static_cast<std::size_t>(k)] + (sector * k + i) % (6 * k);
        };
        const auto inner = [&](int i) {
          return k == 1 ? 0 : first[static_cast<std::size_t>(k) - 1] + (sector * (k - 1) + i) % (6 * (k - 1));
        };
        cloth.nodes.insert(cloth.nodes.end(), {outer(j), outer(j + 1), inner(j)});
        if (j < k - 1) cloth.nodes.insert(cloth.nodes.end(), {inner(j), outer(j + 1), inner(j + 1)});
      }
  mesh.blocks = {std::move(cloth), std::move(edge)};
  return mesh;
}

/// The lowest angular frequencies of small motion about a state, from K v = omega^2 M v with the assembled
/// tangent and the lumped mass: subspace iteration with 2 count + 8 vectors until they stand still.
inline std::vector<double> frequencies(const Model& model, const std::vector<double>& u, int count) {
  Assembler assembler(model, 1);
  const LoadValues loads = *evaluate_loads(model, 0);
  const auto n = static_cast<Eigen::Index>(model.equation_count());
  std::vector<double> residual(model.equation_count());
  assembler.assemble({.displacement = u, .load_displacement = u, .loads = loads, .tangent = true}, residual);
  assembler.eliminate_held();
  la::CholeskySolver solver;
  const auto positive = solver.factor(assembler.tangent());
  EXPECT_TRUE(positive && *positive) << "the state is not a stable equilibrium";
  if (!positive || !*positive) return std::vector<double>(static_cast<std::size_t>(count), 0.0);

  Eigen::VectorXd mass(n);
  for (Eigen::Index i = 0; i < n; ++i)
    mass(i) = model.held[static_cast<std::size_t>(i)] ? 0 : model.mass[static_cast<std::size_t>(i / 3)];
  Numbers numbers;
  Eigen::MatrixXd V = Eigen::MatrixXd::NullaryExpr(n, 2 * count + 8, [&] { return numbers(); });
  Eigen::VectorXd before = Eigen::VectorXd::Zero(count), omega2 = before;
  for (int k = 0; k < 100; ++k) {
    const Eigen::MatrixXd MV = mass.asDiagonal() * V;
    for (Eigen::Index j = 0; j < V.cols(); ++j)
      EXPECT_TRUE(solver.solve({MV.col(j).data(), model.equation_count()},
                               {V.col(j).data(), model.equation_count()}));
    const Eigen::GeneralizedSelfAdjointEigenSolver<Eigen::MatrixXd> ritz(
        V.transpose() * MV, V.transpose() * (mass.asDiagonal() * V));
    V = (V * ritz.eigenvectors()).eval();
    omega2 = ritz.eigenvalues().head(count);
    if ((omega2 - before).cwiseAbs().maxCoeff() < 1e-9 * omega2(count - 1)) break;
    before = omega2;
  }
  std::vector<double> omega;
  for (const double value : omega2) omega.push_back(std::sqrt(value));
  return omega;
}

} // namespace drogue::structure::test
