// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/forces.hpp"

#include <algorithm>

#include "common/la_krylov/session.hpp"
#include "fluid_solver/face_rule.hpp"
#include "fluid_solver/flow_fields.hpp"

namespace drogue::fluid {
namespace {

/// Adds int (x - about) x t over a face, t = p n + viscous traction [stress / density]; x p is of degree 2.
void add_moment(const FaceTraction& t, const BoundaryFace& face, std::span<const double> x,
                std::span<const double> p, const ForceSettings& report, double density,
                std::array<double, 3>& moment) {
  const auto normal = area_vector(face, x);
  for (const auto& [N, share] : face_rule(face.corners)) {
    double arm[3] = {-report.moment_about[0], -report.moment_about[1], -report.moment_about[2]};
    double p_point = 0;
    for (std::size_t a = 0; a < face.corners; ++a) {
      const auto node = static_cast<std::size_t>(face.corner[a]);
      p_point += N[a] * p[node];
      for (std::size_t d = 0; d < 3; ++d) arm[d] += N[a] * x[3 * node + d];
    }
    double force[3];
    for (std::size_t d = 0; d < 3; ++d)
      force[d] = density * share * (p_point * normal[d] + t.area * t.viscous[d]);
    for (std::size_t d = 0; d < 3; ++d)
      moment[d] += arm[(d + 1) % 3] * force[(d + 2) % 3] - arm[(d + 2) % 3] * force[(d + 1) % 3];
  }
}

} // namespace

std::vector<SurfaceForce> surface_forces(const Settings& settings, const FluidMesh& mesh,
                                         const FlowSolver& solver) {
  const std::vector<double> u = solver.velocity_np1();
  const std::vector<double> p = solver.pressure_np1();
  const StepData& data = solver.step_data();
  const la::RowRange own = solver.system().own_rows();
  const auto n = static_cast<std::size_t>(solver.system().unknowns());
  const double per_time = n == 8 ? 1 / data.dt : 1.0; // the slab's residual is integrated over the step
  const auto residual = solver.system().residual();
  std::vector<SurfaceForce> forces;
  for (const ForceSettings& report : settings.forces) {
    const auto boundaries = boundary_indices(mesh, report.boundaries);
    SurfaceForce force;
    for (const BoundaryFace& face : mesh.faces) {
      if (std::find(boundaries.begin(), boundaries.end(), face.boundary) == boundaries.end()) continue;
      const FaceTraction t = face_traction(settings, mesh, data.x_np1, u, p, face);
      for (std::size_t d = 0; d < 3; ++d) {
        force.pressure[d] += settings.density * t.area * t.pressure[d];
        force.viscous[d] += settings.density * t.area * t.viscous[d];
      }
      add_moment(t, face, data.x_np1, p, report, settings.density, force.moment);
    }
    for (const std::int32_t node : mesh.nodes_of(boundaries)) {
      if (!own.has(node)) continue;
      for (std::size_t q = 0; q < n; q += 4)
        for (std::size_t d = 0; d < 3; ++d)
          force.reaction[d] -=
              settings.density * per_time * residual[static_cast<std::size_t>(node - own.first) * n + q + d];
    }
    la::sum_over_ranks(force.reaction.data(), 3);
    forces.push_back(force);
  }
  return forces;
}

} // namespace drogue::fluid
