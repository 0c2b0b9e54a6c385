// SPDX-License-Identifier: GPL-3.0-or-later
//
// Membranes, solids and follower pressure of every kind: tangent against finite differences, force against
// the energy's derivative, rigid motion, rank, mass, and which elements they refuse.
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "structure_solver/elements/follower_pressure.hpp"
#include "structure_solver/elements/registry.hpp"
#include "tests/structure_solver/test_structures.hpp"

namespace drogue::structure {
namespace {

using mesh::ElementKind;
using test::Numbers;
using Vector = std::vector<double>;

/// Answer of a kernel, its matrices flat.
struct Answer {
  Vector force, tangent;
  double energy = 0;
};

/// A kernel behind functions of plain vectors, so that each check is compiled once: positions {nodes, 3}.
struct Subject {
  std::string name;
  ElementKind kind;
  bool solid = false;
  std::function<Answer(const Vector& X, const Vector& x)> evaluate;
  std::function<Vector(const Vector& X)> mass;
  std::function<double(const Vector& X)> measure; ///< area times thickness, or volume
  std::function<bool(const Vector& X)> regular;

  [[nodiscard]] bool flat() const { return mesh::dimension(kind) == 2; }
  [[nodiscard]] bool plane() const { return solid && flat(); }
};

template <int Nodes>
typename Response<Nodes>::Positions matrix(const Vector& x) {
  return Eigen::Map<const typename Response<Nodes>::Positions>(x.data());
}

template <int Nodes>
Answer answer(const Response<Nodes>& r) {
  return {Vector(r.force.data(), r.force.data() + r.force.size()),
          Vector(r.tangent.data(), r.tangent.data() + r.tangent.size()), r.energy};
}

constexpr double density = 6, thickness = 0.01;

template <class Kernel>
Subject subject(const std::string& name, const typename Kernel::Material& material, double depth) {
  constexpr int n = Kernel::nodes;
  Subject s;
  s.name = name;
  s.kind = Kernel::kind;
  s.solid = std::is_same_v<typename Kernel::Material, SolidMaterial>;
  s.evaluate = [material](const Vector& X, const Vector& x) {
    Response<n> r;
    Kernel::evaluate(Kernel::reference(matrix<n>(X)), material, matrix<n>(x), true, r);
    return answer(r);
  };
  s.mass = [material](const Vector& X) {
    const auto m = Kernel::lumped_mass(Kernel::reference(matrix<n>(X)), material);
    return Vector(m.data(), m.data() + n);
  };
  s.measure = [depth](const Vector& X) {
    double sum = 0;
    for (const double v : Kernel::reference(matrix<n>(X)).measure) sum += v;
    return depth * sum;
  };
  s.regular = [](const Vector& X) { return Kernel::regular(matrix<n>(X), Kernel::reference(matrix<n>(X))); };
  return s;
}

template <ElementKind Kind>
Subject membrane(const std::string& name, double prestress) {
  MembraneMaterial m;
  m.thickness = thickness;
  m.density = density;
  m.youngs_modulus = 2e5;
  m.poisson_ratio = 0.3;
  m.prestress = prestress;
  return subject<Membrane<Kind>>(name, m, thickness);
}
template <ElementKind Kind>
Subject solid(const std::string& name) {
  return subject<Solid<Kind>>(name, {density, 2e5, 0.3}, 1);
}

std::vector<Subject> subjects(double prestress) {
  return {membrane<ElementKind::tri3>("membrane T3", prestress),
          membrane<ElementKind::tri6>("membrane T6", prestress),
          membrane<ElementKind::quad4>("membrane Q4", prestress),
          membrane<ElementKind::quad9>("membrane Q9", prestress),
          solid<ElementKind::tri6>("solid T6"),
          solid<ElementKind::quad9>("solid Q9"),
          solid<ElementKind::tet10>("solid Tet10"),
          solid<ElementKind::hex27>("solid Hex27")};
}

/// Parent coordinates of the nodes: corners, then the middles of the edges, then the centre.
std::vector<std::array<double, 3>> parent_nodes(ElementKind kind) {
  std::vector<std::array<double, 3>> nodes;
  const auto count = static_cast<std::size_t>(mesh::nodes_per_element(kind));
  if (mesh::dimension(kind) == 3) {
    for (std::size_t a = 0; a < count; ++a) nodes.push_back(fem::volume_node(kind, static_cast<int>(a)));
    return nodes;
  }
  if (mesh::dimension(kind) == 1)
    nodes = {{-1, 0, 0}, {1, 0, 0}};
  else if (fem::is_quadrilateral(kind))
    nodes = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}};
  else
    nodes = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const std::size_t corners = nodes.size();
  for (std::size_t a = 0; nodes.size() < count && a < corners; ++a) {
    const auto p = nodes[a], q = nodes[(a + 1) % corners];
    nodes.push_back({0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1]), 0});
  }
  if (nodes.size() < count) nodes.push_back({0, 0, 0});
  return nodes;
}

/// Reference positions of one distorted element; those of a plane solid lie in z = 0.
Vector reference_positions(const Subject& s) {
  Vector X;
  Numbers numbers;
  for (const auto& p : parent_nodes(s.kind)) {
    X.push_back(p[0] + 0.2 * p[1] + 0.05 * numbers());
    X.push_back(p[1] - 0.1 * p[0] + 0.05 * numbers());
    X.push_back(p[2] + 0.3 * p[0] * p[1] + 0.05 * numbers());
    if (s.plane()) X.back() = 0;
  }
  return X;
}

Vector moved(Vector x, double amount) {
  Numbers numbers;
  for (double& value : x) value += amount * numbers();
  return x;
}

double largest(const Vector& x) {
  double value = 0;
  for (const double v : x) value = std::max(value, std::abs(v));
  return value;
}

/// Largest difference between the tangent and central differences, relative to its largest entry.
double tangent_error(const Vector& x, const std::function<Answer(const Vector&)>& evaluate) {
  const Answer exact = evaluate(x);
  const double h = 1e-6;
  double error = 0;
  for (std::size_t j = 0; j < x.size(); ++j) {
    Vector xp = x, xm = x;
    xp[j] += h;
    xm[j] -= h;
    const Answer plus = evaluate(xp), minus = evaluate(xm);
    for (std::size_t i = 0; i < x.size(); ++i)
      error = std::max(
          error, std::abs((plus.force[i] - minus.force[i]) / (2 * h) - exact.tangent[j * x.size() + i]));
  }
  return error / largest(exact.tangent);
}

TEST(Kernels, TangentAndForceAreDerivatives) {
  for (const Subject& s : subjects(400)) {
    SCOPED_TRACE(s.name);
    const Vector X = reference_positions(s), x = moved(X, 0.15);
    const auto evaluate = [&](const Vector& y) { return s.evaluate(X, y); };
    EXPECT_LT(tangent_error(x, evaluate), 1e-8);
    const Answer at = evaluate(x);
    const double h = 1e-6, scale = largest(at.force);
    for (std::size_t j = 0; j < x.size(); ++j) {
      Vector xp = x, xm = x;
      xp[j] += h;
      xm[j] -= h;
      EXPECT_NEAR(at.force[j], (evaluate(xp).energy - evaluate(xm).energy) / (2 * h), 1e-7 * scale);
    }
  }
}

TEST(Kernels, AWrongTangentIsSeen) {
  for (const Subject& s : subjects(0)) {
    const Vector X = reference_positions(s);
    const double error = tangent_error(moved(X, 0.15), [&](const Vector& y) {
      Answer a = s.evaluate(X, y);
      for (double& k : a.tangent) k *= 1 + 1e-6;
      return a;
    });
    EXPECT_GT(error, 5e-7) << s.name;
  }
}

TEST(Kernels, RigidMotionGivesNoForce) {
  for (const Subject& s : subjects(0)) {
    const Eigen::Vector3d axis =
        s.plane() ? Eigen::Vector3d(0, 0, 1) : Eigen::Vector3d(1, -2, 0.5).normalized();
    const Eigen::Matrix3d R = Eigen::AngleAxisd(2.1, axis).toRotationMatrix();
    const Vector X = reference_positions(s);
    Vector x(X.size());
    for (std::size_t i = 0; i < X.size(); i += 3) {
      const Eigen::Vector3d turned =
          R * Eigen::Vector3d(X[i], X[i + 1], X[i + 2]) + Eigen::Vector3d(30, -20, 10);
      for (std::size_t c = 0; c < 3; ++c) x[i + c] = turned(static_cast<int>(c));
    }
    const Answer a = s.evaluate(X, x);
    // A force of this size comes from strains of rounding size, at coordinates of size 30.
    EXPECT_LT(largest(a.force), 1e-13 * largest(a.tangent)) << s.name;
  }
}

/// Rank of a positive semi-definite matrix, by elimination with the largest pivot.
std::size_t rank(Vector K, std::size_t n) {
  const double first = largest(K);
  std::vector<bool> done(n, false);
  for (std::size_t found = 0; found < n; ++found) {
    std::size_t p = n;
    for (std::size_t i = 0; i < n; ++i)
      if (!done[i] && (p == n || K[i * n + i] > K[p * n + p])) p = i;
    if (!(K[p * n + p] > 1e-9 * first)) return found;
    done[p] = true;
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t j = 0; j < n; ++j)
        if (!done[i] && !done[j]) K[i * n + j] -= K[i * n + p] * K[p * n + j] / K[p * n + p];
  }
  return n;
}

/// Rigid motions are the only ones that cost nothing: there are no spurious modes.
TEST(Kernels, TangentHasTheRankOfTheStrains) {
  for (const Subject& s : subjects(0)) {
    Vector X = reference_positions(s);
    if (s.flat())
      for (std::size_t i = 2; i < X.size(); i += 3) X[i] = 0;
    EXPECT_EQ(rank(s.evaluate(X, X).tangent, X.size()), s.flat() ? 2 * X.size() / 3 - 3 : X.size() - 6)
        << s.name;
  }
}

TEST(Kernels, MassIsPositiveAndThatOfTheMaterial) {
  for (const Subject& s : subjects(0)) {
    const Vector X = reference_positions(s);
    double sum = 0;
    for (const double m : s.mass(X)) {
      EXPECT_GT(m, 0) << s.name;
      sum += m;
    }
    EXPECT_NEAR(sum, density * s.measure(X), 1e-13 * sum) << s.name;
  }
}

TEST(Kernels, RefuseIrregularElements) {
  for (const Subject& s : subjects(0)) {
    SCOPED_TRACE(s.name);
    const Vector X = reference_positions(s);
    EXPECT_TRUE(s.regular(X));
    Vector flat = X, inside_out = X, crossed = X;
    for (std::size_t i = 0; i < X.size(); i += 3) {
      flat[i + 1] = 0.5 * X[i]; // all on one line, or in one plane
      flat[i + 2] = s.plane() ? 0 : X[i];
      inside_out[i + 1] *= -1;
    }
    EXPECT_FALSE(s.regular(flat));
    EXPECT_EQ(s.regular(inside_out), !s.solid); // a membrane has no inside
    if (s.kind == ElementKind::tri3) continue;
    for (std::size_t c = 0; c < 3; ++c) std::swap(crossed[3 + c], crossed[6 + c]);
    EXPECT_FALSE(s.regular(crossed));
  }
}

/// S of a given F against S = lambda tr(E) I + 2 mu E written out.
TEST(Solid, StressIsThatOfTheLaw) {
  using Kernel = Solid<ElementKind::tri6>;
  const SolidMaterial m{1, 1.4e6, 0.4};
  EXPECT_NEAR(m.lambda(), 2e6, 1e-8);
  EXPECT_NEAR(m.mu(), 5e5, 1e-8);
  const Vector X = reference_positions(solid<ElementKind::tri6>(""));
  Vector x = X;
  for (std::size_t i = 0; i < X.size(); i += 3) {
    x[i] = 1.1 * X[i] + 0.2 * X[i + 1];
    x[i + 1] = 0.9 * X[i + 1];
  }
  const auto s = Kernel::point_state(Kernel::reference(matrix<6>(X)), m, matrix<6>(x), 4);
  // E_11 = (1.21 - 1)/2, E_22 = (0.04 + 0.81 - 1)/2, E_12 = 0.22/2
  EXPECT_NEAR(s.S(0, 0), 2e6 * 0.03 + 1e6 * 0.105, 1e-6);
  EXPECT_NEAR(s.S(1, 1), 2e6 * 0.03 - 1e6 * 0.075, 1e-6);
  EXPECT_NEAR(s.S(0, 1), 1e6 * 0.11, 1e-6);
  const PrincipalStress p = Kernel::principal_stress(s);
  EXPECT_NEAR(p.largest + p.smallest, s.S.trace(), 1e-6);
  EXPECT_NEAR(p.largest * p.smallest, s.S.determinant(), 1);
}

template <ElementKind Kind>
double pressure_error() {
  using Kernel = FollowerPressure<Kind>;
  Numbers numbers;
  typename Kernel::NodalPressure p;
  Vector x;
  int a = 0;
  for (const auto& node : parent_nodes(Kind)) {
    p(a++) = 2 + numbers();
    for (const double c : node) x.push_back(c + 0.15 * numbers());
  }
  return tangent_error(x, [&p](const Vector& y) {
    Response<Kernel::nodes> r;
    Kernel::evaluate(element_rule<Kind>(), p, matrix<Kernel::nodes>(y), true, r);
    return answer(r);
  });
}

TEST(FollowerPressure, LoadStiffnessIsTheDerivativeOnEveryKind) {
  EXPECT_LT(pressure_error<ElementKind::line2>(), 1e-9);
  EXPECT_LT(pressure_error<ElementKind::line3>(), 1e-9);
  EXPECT_LT(pressure_error<ElementKind::tri3>(), 1e-9);
  EXPECT_LT(pressure_error<ElementKind::tri6>(), 1e-9);
  EXPECT_LT(pressure_error<ElementKind::quad4>(), 1e-9);
  EXPECT_LT(pressure_error<ElementKind::quad9>(), 1e-9);
}

} // namespace
} // namespace drogue::structure
