// SPDX-License-Identifier: GPL-3.0-or-later
//
// Membranes against exact solutions of the St. Venant-Kirchhoff law: the clamped circular membrane under
// lateral load and follower pressure (shooting; agrees with [fichter1997] to his printed digits), the
// pressurised sphere and cylinder, and the frequencies of a drum.
#include <gtest/gtest.h>

#include "structure_solver/fields.hpp"
#include "tests/support/verify.hpp"
#include "tests/verification/structure_shapes.hpp"

namespace drogue::structure {
namespace {

using drogue::test::verify_between;
using drogue::test::verify_relative;
using mesh::ElementKind;

/// Static equilibrium by steps so long that inertia does not count, from a shape under tension.
State equilibrium(const Model& model, State start, bool follower) {
  Integrator integrator(
      model, {0.0, 0.0, {.displacement_tolerance = 1e-9, .max_iterations = 60, .load_stiffness = follower}},
      std::move(start));
  test::settle(integrator, 1e5, 3);
  EXPECT_LT(integrator.balance().unbalance, 1e-6);
  return integrator.committed();
}

/// At the centre of the disk.
struct Centre {
  double deflection = 0, stress = 0;
};

/// The clamped unit disk under q; E = t = a = 1, nu = 0.3.
Centre load_disk(mesh::Mesh mesh, double q, bool follower) {
  Settings s;
  s.membranes = {{"cloth", {1.0, 1.0, 1.0, 0.3, 0}}};
  s.supports = {{"edge", {true, true, true}, {}}};
  if (follower)
    s.pressures = {{"cloth", test::expression(fmt::format("{:.17g}", q))}};
  else
    s.tractions = {{"cloth", test::vector("0", "0", fmt::format("{:.17g}", q))}};
  const Model model = test::model(s, std::move(mesh));
  State start = rest_state(model);
  std::size_t centre = 0;
  double nearest = 2;
  for (std::size_t i = 0; i < model.node_count(); ++i) {
    const double r = std::hypot(model.mesh.points[3 * i], model.mesh.points[3 * i + 1]);
    start.u[3 * i + 2] = model.held[3 * i] ? 0 : 0.6 * std::cbrt(q) * (1 - r * r);
    if (r < nearest) {
      nearest = r;
      centre = i;
    }
  }
  const State state = equilibrium(model, std::move(start), follower);
  const StressFields stress = stress_fields(model, state.u, state.time);
  return {state.u[3 * centre + 2], 0.5 * (stress.nodal_largest[centre] + stress.nodal_smallest[centre])};
}

double deflection(mesh::Mesh mesh, double q, bool follower) {
  return load_disk(std::move(mesh), q, follower).deflection;
}

struct Row {
  double q;
  const char* name;
  double lateral, follower;
};
constexpr std::array<Row, 3> exact_disk = {{{1e-4, "deflection_q1e-4", 0.030329, 0.030336},
                                            {1e-3, "deflection_q1e-3", 0.065338, 0.065404},
                                            {1e-2, "deflection_q1e-2", 0.140729, 0.141385}}};

TEST(CircularMembrane, TrianglesWithinHalfAPercent) {
  for (const Row& row : exact_disk) {
    verify_relative("structure/disk_t3_lateral", row.name, deflection(test::triangle_disk(25), row.q, false),
                    row.lateral, 5e-3);
    verify_relative("structure/disk_t3_follower", row.name, deflection(test::triangle_disk(25), row.q, true),
                    row.follower, 5e-3);
  }
}

TEST(CircularMembrane, NineNodeQuadrilateralsWithinAThousandth) {
  for (const Row& row : exact_disk) {
    verify_relative("structure/disk_q9_lateral", row.name, deflection(test::quad_disk(8, 6), row.q, false),
                    row.lateral, 1e-3);
    verify_relative("structure/disk_q9_follower", row.name, deflection(test::quad_disk(8, 6), row.q, true),
                    row.follower, 1e-3);
  }
}

TEST(CircularMembrane, StressAtTheCentre) {
  const double q = 1e-2, lateral = 0.019641, follower = 0.020395;
  verify_relative("structure/disk_t3_lateral", "centre_stress",
                  load_disk(test::triangle_disk(25), q, false).stress, lateral, 5e-3);
  verify_relative("structure/disk_t3_follower", "centre_stress",
                  load_disk(test::triangle_disk(25), q, true).stress, follower, 5e-3);
  verify_relative("structure/disk_q9_follower", "centre_stress",
                  load_disk(test::quad_disk(8, 6), q, true).stress, follower, 5e-3);
}

/// From three meshes, each with half the element size of the one before.
TEST(CircularMembrane, OrderOfConvergence) {
  const auto order = [](const std::array<double, 3>& w) { return std::log2((w[0] - w[1]) / (w[1] - w[2])); };
  std::array<double, 3> t3{}, q9{};
  for (int k = 0; k < 3; ++k) {
    const auto i = static_cast<std::size_t>(k);
    t3[i] = deflection(test::triangle_disk(6 << k), 1e-2, true);
    q9[i] = deflection(test::quad_disk(2 << k, 2 << k), 1e-2, true);
  }
  verify_between("structure/disk_t3_follower", "order", order(t3), 1.8, 2.3);
  verify_between("structure/disk_q9_follower", "order", order(q9), 2.5, 4.5);
}

/// An eighth of the unit sphere: three squares that meet at (1, 1, 1) / sqrt(3). Points "x0", "y0", "z0".
mesh::Mesh octant(ElementKind kind, int n) {
  test::PatchWork work(kind);
  for (int axis = 0; axis < 3; ++axis)
    work.add(n, n, [axis](double s, double t) {
      const double quarter = 0.25 * std::numbers::pi;
      Eigen::Vector3d x; // equal angles along the sides of the cube
      x(axis) = 1;
      x((axis + 1) % 3) = std::tan(quarter * s);
      x((axis + 2) % 3) = std::tan(quarter * t);
      return Eigen::Vector3d(x.normalized());
    });
  for (int c = 0; c < 3; ++c)
    work.group(std::string(1, "xyz"[c]) + "0",
               [c](const Eigen::Vector3d& X) { return std::abs(X(c)) < 1e-9; });
  return work.mesh();
}

/// R = E = t = 1, nu = 0.3; the pressure of an exact stretch of lambda = 1.1.
void check_sphere(const char* name, ElementKind kind, int n) {
  const double lambda = 1.1, nu = 0.3, p = (lambda * lambda - 1) / lambda / (1 - nu);
  Settings s;
  s.membranes = {{"cloth", {1.0, 1.0, 1.0, nu, 0}}};
  s.supports = {
      {"x0", {true, false, false}, {}}, {"y0", {false, true, false}, {}}, {"z0", {false, false, true}, {}}};
  s.pressures = {{"cloth", test::expression(fmt::format("{:.17g}", p))}};
  const Model model = test::model(s, octant(kind, n));
  State start = rest_state(model);
  for (std::size_t i = 0; i < start.u.size(); ++i) start.u[i] = 0.05 * model.mesh.points[i];
  const State state = equilibrium(model, std::move(start), true);
  double mean = 0;
  for (std::size_t i = 0; i < model.node_count(); ++i)
    mean += Eigen::Map<const Eigen::Vector3d>(&state.u[3 * i])
                .dot(Eigen::Map<const Eigen::Vector3d>(&model.mesh.points[3 * i]));
  verify_relative(name, "radial_displacement", mean / static_cast<double>(model.node_count()), lambda - 1,
                  2e-3);
}

TEST(PressurisedSphere, ExactStretch) {
  check_sphere("structure/sphere_q9", ElementKind::quad9, 4);
  check_sphere("structure/sphere_t3", ElementKind::tri3, 12);
}

/// Quarter of a cylinder, R = E = t = 1, nu = 0.3, no axial strain: p (1 - nu^2) = (lambda^2 - 1) / 2.
void check_cylinder(const char* name, ElementKind kind, int n) {
  const double lambda = 1.1, nu = 0.3, p = 0.5 * (lambda * lambda - 1) / (1 - nu * nu);
  Settings s;
  s.membranes = {{"cloth", {1.0, 1.0, 1.0, nu, 0}}};
  s.supports = {
      {"x0", {true, false, false}, {}}, {"y0", {false, true, false}, {}}, {"all", {false, false, true}, {}}};
  s.pressures = {{"cloth", test::expression(fmt::format("{:.17g}", p))}};
  test::PatchWork work(kind);
  work.add(n, 2, [](double u, double z) {
    const double angle = 0.5 * std::numbers::pi * u;
    return Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.3 * z);
  });
  work.group("x0", [](const Eigen::Vector3d& X) { return std::abs(X(0)) < 1e-9; });
  work.group("y0", [](const Eigen::Vector3d& X) { return std::abs(X(1)) < 1e-9; });
  work.group("all", [](const Eigen::Vector3d&) { return true; });
  const Model model = test::model(s, work.mesh());
  State start = rest_state(model);
  for (std::size_t i = 0; i < start.u.size(); ++i) start.u[i] = i % 3 == 2 ? 0 : 0.05 * model.mesh.points[i];
  const State state = equilibrium(model, std::move(start), true);
  double mean = 0;
  for (std::size_t i = 0; i < model.node_count(); ++i)
    mean += state.u[3 * i] * model.mesh.points[3 * i] + state.u[3 * i + 1] * model.mesh.points[3 * i + 1];
  verify_relative(name, "radial_displacement", mean / static_cast<double>(model.node_count()), lambda - 1,
                  2e-3);
}

TEST(PressurisedCylinder, ExactStretch) {
  check_cylinder("structure/cylinder_q9", ElementKind::quad9, 6);
  check_cylinder("structure/cylinder_t3", ElementKind::tri3, 24);
}

/// omega_mn = j_mn / R sqrt(N / (rho t)); modes with m > 0 come twice.
void check_drum(const char* name, mesh::Mesh mesh) {
  Settings s;
  s.membranes = {{"cloth", {0.01, 2.0, 1e6, 0.3, 10.0}}};
  s.supports = {{"edge", {true, true, true}, {}}};
  const Model model = test::model(s, std::move(mesh));
  const auto omega = test::frequencies(model, rest_state(model).u, 6);
  const std::array<double, 6> zero = {2.40483, 3.83171, 3.83171, 5.13562, 5.13562, 5.52008};
  const std::array<const char*, 6> mode = {"omega_01", "omega_11", "", "omega_21", "", "omega_02"};
  for (std::size_t k = 0; k < 6; ++k)
    if (*mode[k]) verify_relative(name, mode[k], omega[k], zero[k] * std::sqrt(10.0 / 2.0), 5e-3);
}

TEST(Drum, Frequencies) {
  check_drum("structure/drum_t3", test::triangle_disk(25));
  check_drum("structure/drum_q9", test::quad_disk(8, 6));
}

} // namespace
} // namespace drogue::structure
