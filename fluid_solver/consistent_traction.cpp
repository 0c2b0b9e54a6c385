// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/consistent_traction.hpp"

#include <algorithm>
#include <cmath>

#include "common/la_direct/direct_solver.hpp"
#include "common/la_krylov/ghost_exchange.hpp"
#include "common/la_krylov/session.hpp"

namespace drogue::fluid {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

/// -rho times a combination of the residuals at both ends of a slab, or of the only one.
std::vector<double> combined(const Settings& settings, const FluidMesh& mesh, const FlowSolver& solver,
                             double at_n, double at_np1) {
  const auto residual = solver.system().residual();
  const auto n = static_cast<std::size_t>(solver.system().unknowns());
  const std::size_t rows = residual.size() / n;
  std::vector<double> own(3 * rows);
  for (std::size_t i = 0; i < rows; ++i)
    for (std::size_t d = 0; d < 3; ++d) {
      const double* R = residual.data() + n * i;
      own[3 * i + d] = -settings.density * (n == 8 ? at_n * R[d] + at_np1 * R[4 + d] : R[d]);
    }
  std::vector<double> all(3 * at(mesh.node_count()));
  la::gather_to_all(la::partition_rows(mesh.graph, la::rank_count()), 3, own, all);
  return all;
}

} // namespace

std::vector<double> nodal_forces(const Settings& settings, const FluidMesh& mesh, const FlowSolver& solver) {
  const double dt = solver.step_data().dt;
  return combined(settings, mesh, solver, -2 / dt, 4 / dt);
}

std::vector<double> mean_nodal_forces(const Settings& settings, const FluidMesh& mesh,
                                      const FlowSolver& solver) {
  const double dt = solver.step_data().dt;
  return combined(settings, mesh, solver, 1 / dt, 1 / dt);
}

Result<std::vector<double>> traction_of(std::span<const double> forces, const FluidMesh& mesh,
                                        std::span<const double> points,
                                        std::span<const std::int32_t> boundaries,
                                        std::span<const std::int32_t> nodes) {
  const auto place = [&](std::int32_t node) {
    return static_cast<int>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
  };
  // 1. mass matrix: int N_a N_b = A / (m (m + 1)) (1 + delta_ab) on a face of m nodes
  std::vector<Eigen::Triplet<double>> entries;
  for (const BoundaryFace& face : mesh.faces) {
    if (std::find(boundaries.begin(), boundaries.end(), face.boundary) == boundaries.end()) continue;
    const auto area = area_vector(face, points);
    const auto m = static_cast<double>(face.corners);
    const double part = std::hypot(area[0], area[1], area[2]) / (m * (m + 1));
    for (const std::int32_t a : face.nodes())
      for (const std::int32_t b : face.nodes())
        entries.emplace_back(place(a), place(b), part * (a == b ? 2 : 1));
  }
  const auto size = static_cast<Eigen::Index>(nodes.size());
  la::SparseMatrix mass(size, size);
  mass.setFromTriplets(entries.begin(), entries.end());
  la::CholeskySolver cholesky;
  const auto factored = cholesky.factor(mass);
  if (!factored) return factored.error();
  if (!*factored) return retryable_error("the mass matrix of the interface is singular: a face has no area");
  // 2. one right-hand side a component
  std::vector<double> columns(3 * nodes.size());
  for (std::size_t k = 0; k < nodes.size(); ++k)
    for (std::size_t d = 0; d < 3; ++d) columns[d * nodes.size() + k] = forces[3 * at(nodes[k]) + d];
  DROGUE_TRY(cholesky.solve(columns, columns, 3));
  std::vector<double> traction(columns.size());
  for (std::size_t k = 0; k < nodes.size(); ++k)
    for (std::size_t d = 0; d < 3; ++d) traction[3 * k + d] = columns[d * nodes.size() + k];
  return traction;
}

} // namespace drogue::fluid
