// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/open_boundary.hpp"

#include <algorithm>
#include <cmath>

#include "fluid_solver/face_rule.hpp"
#include "fluid_solver/slab_rule.hpp"

namespace drogue::fluid {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

} // namespace

/// F and its derivative with respect to the nodal velocities at one instant.
struct OpenBoundary::Terms {
  double force[3][3] = {};
  double tangent[3][3][3][3] = {}; ///< [a][b][i][j]
};

OpenBoundary::OpenBoundary(const Settings& settings, const FluidMesh& mesh, const la::RowRange& own,
                           const la::LocalPattern& pattern)
    : boundaries_(settings.boundaries), density_(settings.density) {
  for (const BoundaryFace& face : mesh.faces) {
    const auto found = std::find_if(boundaries_.begin(), boundaries_.end(), [&](const BoundarySettings& b) {
      return b.name == mesh.boundaries[at(face.boundary)];
    });
    if (!found->is_open()) continue;
    if (found->condition == Condition::traction_free && found->backflow == 0) continue;
    const auto nodes = face.nodes();
    if (std::none_of(nodes.begin(), nodes.end(), [&](std::int32_t i) { return own.has(i); })) continue;
    Face f{face, static_cast<std::int32_t>(found - boundaries_.begin()), {}, {}};
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      f.row[a] = own.has(nodes[a]) ? nodes[a] - own.first : -1;
      for (std::size_t b = 0; b < nodes.size(); ++b)
        f.entry[a][b] = f.row[a] < 0 ? -1 : pattern.find(f.row[a], pattern.local(own, nodes[b]));
    }
    faces_.push_back(f);
  }
}

OpenBoundary::Terms OpenBoundary::evaluate(const Face& face, const StepData& data, std::size_t unknowns,
                                           double theta) const {
  // 1. nodal values at the instant
  const BoundarySettings& b = boundaries_[at(face.boundary)];
  const auto nodes = face.face.nodes();
  double x[9] = {};
  double u[3][3] = {};
  double relative[3][3] = {};
  for (std::size_t a = 0; a < nodes.size(); ++a) {
    const std::size_t node = at(nodes[a]);
    const double* w = data.unknowns.data() + unknowns * node;
    for (std::size_t d = 0; d < 3; ++d) {
      const double x0 = data.x_n[3 * node + d];
      const double x1 = data.x_np1[3 * node + d];
      x[3 * a + d] = (1 - theta) * x0 + theta * x1;
      u[a][d] = unknowns == 8 ? (1 - theta) * w[d] + theta * w[4 + d] : w[d];
      relative[a][d] = u[a][d] - (x1 - x0) / data.dt;
    }
  }
  const auto area = area_vector({{0, 1, 2}, nodes.size(), 0, 0}, x);
  const double t = data.t_n + theta * data.dt;
  // 2. quadrature; area carries the normal
  Terms terms;
  for (const auto& [N, share] : face_rule(nodes.size())) {
    double p[3];
    double uq[3];
    double flux = 0;
    for (std::size_t d = 0; d < 3; ++d) {
      p[d] = N[0] * x[d] + N[1] * x[3 + d] + N[2] * x[6 + d];
      uq[d] = N[0] * u[0][d] + N[1] * u[1][d] + N[2] * u[2][d];
      flux += area[d] * (N[0] * relative[0][d] + N[1] * relative[1][d] + N[2] * relative[2][d]);
    }
    const double inflow = b.backflow * share * std::min(flux, 0.0);
    const double traction_weight = std::hypot(area[0], area[1], area[2]) * share / density_;
    for (std::size_t i = 0; i < 3; ++i) {
      const double traction = b.condition == Condition::traction ? b.value[i](p[0], p[1], p[2], t) : 0.0;
      for (int a = 0; a < 3; ++a) terms.force[a][i] -= N[a] * (traction_weight * traction + inflow * uq[i]);
    }
    if (inflow == 0) continue;
    for (int a = 0; a < 3; ++a)
      for (int c = 0; c < 3; ++c)
        for (std::size_t i = 0; i < 3; ++i) {
          terms.tangent[a][c][i][i] -= N[a] * N[c] * inflow;
          for (std::size_t j = 0; j < 3; ++j)
            terms.tangent[a][c][i][j] -= N[a] * N[c] * b.backflow * share * uq[i] * area[j];
        }
  }
  return terms;
}

template <int n, int points>
void OpenBoundary::add_with(const StepData& data, std::span<const double, n> scale,
                            std::span<double> residual, la::BlockMatrix<n>* jacobian) const {
  constexpr int levels = n / 4;
  constexpr SlabRule<points> slab;
  for (const Face& face : faces_)
    for (int point = 0; point < points; ++point) {
      const double theta = slab.theta[point];
      const double T[2] = {levels == 2 ? 1 - theta : 1.0, theta};
      const double weight = slab.weight[point] * (levels == 2 ? data.dt : 1.0);
      const Terms terms = evaluate(face, data, n, theta);
      const int nodes = static_cast<int>(face.face.corners);
      for (int a = 0; a < nodes; ++a) {
        if (face.row[a] < 0) continue;
        for (int al = 0; al < levels; ++al)
          for (int i = 0; i < 3; ++i)
            residual[at(face.row[a]) * n + at(4 * al + i)] += weight * T[al] * terms.force[a][i];
        if (jacobian == nullptr) continue;
        for (int c = 0; c < nodes; ++c) {
          float* block = jacobian->block(face.entry[a][c]);
          for (int be = 0; be < levels; ++be)
            for (int al = 0; al < levels; ++al)
              for (int j = 0; j < 3; ++j)
                for (int i = 0; i < 3; ++i)
                  block[n * (4 * be + j) + 4 * al + i] +=
                      static_cast<float>(weight * T[al] * T[be] * scale[at(4 * al + i)] *
                                         scale[at(4 * be + j)] * terms.tangent[a][c][i][j]);
        }
      }
    }
}

template <int n>
void OpenBoundary::add(const StepData& data, std::span<const double, n> scale, std::span<double> residual,
                       la::BlockMatrix<n>* jacobian) const {
  if constexpr (n == 4)
    add_with<n, 1>(data, scale, residual, jacobian);
  else if (data.time_points == 2)
    add_with<n, 2>(data, scale, residual, jacobian);
  else
    add_with<n, 3>(data, scale, residual, jacobian);
}

template void OpenBoundary::add<4>(const StepData&, std::span<const double, 4>, std::span<double>,
                                   la::BlockMatrix<4>*) const;
template void OpenBoundary::add<8>(const StepData&, std::span<const double, 8>, std::span<double>,
                                   la::BlockMatrix<8>*) const;

} // namespace drogue::fluid
