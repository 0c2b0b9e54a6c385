// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include <unistd.h>

#include <gtest/gtest.h>

#include "structure_solver/run.hpp"
#include "structure_solver/state_io.hpp"
#include "tests/support/t10_structure.hpp"

/// An inflated T-10 and the balance of its forces.
namespace drogue::structure::test {

inline Eigen::Vector3d place(const Model& model, const State& state, std::int32_t node) {
  const std::size_t i = 3 * static_cast<std::size_t>(node);
  return Eigen::Map<const Eigen::Vector3d>(&model.mesh.points[i]) +
         Eigen::Map<const Eigen::Vector3d>(&state.u[i]);
}

/// Runs a case as `structure_solver run` does and returns the state at the end.
inline State inflate(Case& c) {
  const auto folder = std::filesystem::temp_directory_path() / ("drogue-t10-" + std::to_string(getpid()));
  c.settings.output.directory = folder;
  c.settings.final_state = folder / "inflated.state";
  const auto done = run(c);
  EXPECT_TRUE(done) << done.error().message;
  auto state = read_state(*c.settings.final_state, *c.model);
  EXPECT_TRUE(state) << state.error().message;
  std::filesystem::remove_all(folder);
  return state ? std::move(*state) : rest_state(*c.model);
}

/// Goes on from near equilibrium with growing steps and the whole tangent until the forces balance to
/// rounding.
inline State polish(const Case& c, State state) {
  state.v.assign(state.v.size(), 0.0);
  state.a.assign(state.a.size(), 0.0);
  Integrator integrator(
      *c.model, {0.0, 20.0, {.displacement_tolerance = 1e-9, .max_iterations = 20, .load_stiffness = true}},
      std::move(state));
  double dt = 0.1;
  for (int k = 0; k < 60 && integrator.balance().unbalance > 1e-9; ++k) {
    integrator.begin_step(dt, Integrator::Predictor::hold);
    const auto outcome = integrator.iterate_to_tolerance();
    const bool converged = outcome && outcome->converged;
    if (converged)
      integrator.commit();
    else
      integrator.rollback();
    dt *= converged ? 3.0 : 0.25;
  }
  return integrator.committed();
}

/// Vertical force of suspension lines and vent lines on the cloth, downwards: of the elements next to the
/// cloth.
inline double vertical_line_force(const Model& model, const State& state) {
  double sum = 0;
  for (const AnyBatch& any : model.batches) {
    const auto* batch = std::get_if<Batch<Line>>(&any);
    if (!batch || batch->group == "radials") continue;
    const std::size_t of_a_line = batch->count() / static_cast<std::size_t>(drogue::test::t10_canopy.gores);
    for (std::size_t e = 0; e < batch->count(); e += of_a_line) {
      Line::Positions x;
      for (int a = 0; a < 2; ++a) x.col(a) = place(model, state, batch->element(e)[a]);
      const double tension = Line::tension(batch->reference[e], batch->material, x);
      sum += tension * (x(2, 0) - x(2, 1)) / (x.col(1) - x.col(0)).norm();
    }
  }
  return sum;
}

/// Area inside the projection of the skirt edge less that inside the vent edge: the integral of (x dy - y dx)
/// / 2 along the free edges of the cloth, exact on straight and quadratic edges.
inline double projected_area(const Model& model, const State& state) {
  using Edge = std::vector<std::int32_t>;
  std::map<std::pair<std::int32_t, std::int32_t>, Edge> free_edges;
  for (const mesh::ElementBlock* block : model.mesh.blocks_of("canopy"))
    for (std::int32_t e = 0; e < block->count(); ++e) {
      const auto n = block->element(e);
      const std::size_t corners = block->kind == mesh::ElementKind::quad9 ? 4 : 3;
      for (std::size_t k = 0; k < corners; ++k) {
        const std::int32_t a = n[k], b = n[(k + 1) % corners];
        if (free_edges.erase({std::min(a, b), std::max(a, b)}) == 0)
          free_edges[{std::min(a, b), std::max(a, b)}] = corners == 4 ? Edge{a, b, n[4 + k]} : Edge{a, b};
      }
    }
  double area = 0;
  for (const auto& [key, edge] : free_edges) {
    const Eigen::Vector3d a = place(model, state, edge[0]), b = place(model, state, edge[1]);
    const auto cross = [](const Eigen::Vector3d& p, const Eigen::Vector3d& q) {
      return p(0) * q(1) - p(1) * q(0);
    };
    area += 0.5 * cross(a, b);
    if (edge.size() < 3) continue;
    const Eigen::Vector3d bulge = place(model, state, edge[2]) - 0.5 * (a + b);
    area += 2.0 / 3.0 * cross(bulge, b - a); // Simpson: the segment between the parabola and its chord
  }
  return area;
}

} // namespace drogue::structure::test
