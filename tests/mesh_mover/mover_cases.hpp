// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <functional>

#include <gtest/gtest.h>

#include "mesh_mover/mover.hpp"

/// Settings and steps that the tests of the mesh mover share.
namespace drogue::mesh_mover {

using Motion = std::function<std::array<double, 3>(const double* X)>;

inline config::Expression expression(const std::string& text) {
  auto parsed = config::Expression::parse(text);
  EXPECT_TRUE(parsed.ok()) << text;
  return std::move(*parsed);
}

inline Boundary moved(std::string name, const std::string& x, const std::string& y,
                      const std::string& z = "0") {
  Boundary boundary;
  boundary.name = std::move(name);
  boundary.condition = Condition::displacement;
  boundary.displacement = {expression(x), expression(y), expression(z)};
  return boundary;
}

inline Boundary boundary(std::string name, Condition condition, int normal = 0) {
  Boundary b;
  b.name = std::move(name);
  b.condition = condition;
  b.normal = normal;
  return b;
}

inline std::unique_ptr<MeshMover> make(mesh::Mesh mesh, const Settings& settings) {
  auto mover = MeshMover::create(std::move(mesh), settings);
  EXPECT_TRUE(mover.ok()) << mover.error().message;
  return std::move(*mover);
}

inline Result<SolveReport> solve_at(MeshMover& mover, double time) {
  BoundaryInput input;
  input.time = time;
  return mover.solve(input);
}

inline SolveReport step_to(MeshMover& mover, double time, double time_step = 1) {
  EXPECT_TRUE(mover.begin_step(time_step).ok());
  const auto report = solve_at(mover, time);
  EXPECT_TRUE(report.ok()) << report.error().message;
  mover.commit();
  return report ? *report : SolveReport{};
}

inline double largest_error(const MeshMover& mover, const Motion& exact) {
  double error = 0;
  const auto u = mover.displacement();
  for (std::size_t i = 0; i < u.size() / 3; ++i) {
    const auto expected = exact(&mover.mesh().points[3 * i]);
    for (std::size_t c = 0; c < 3; ++c) error = std::max(error, std::abs(u[3 * i + c] - expected[c]));
  }
  return error;
}

} // namespace drogue::mesh_mover
