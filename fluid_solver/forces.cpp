// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/forces.hpp"

#include <algorithm>

#include "common/la_krylov/session.hpp"
#include "fluid_solver/flow_fields.hpp"

namespace drogue::fluid {

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
