// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/probes.hpp"

#include <algorithm>
#include <limits>

#include "fluid_solver/tet_geometry.hpp"

namespace drogue::fluid {

Result<Probes> Probes::create(const Settings& settings, const FluidMesh& mesh) {
  Probes probes;
  for (const ProbeSettings& probe : settings.probes) {
    Place best;
    double best_weight = -std::numeric_limits<double>::infinity(); // smallest barycentric weight
    for (std::size_t e = 0; e < mesh.tets.size(); e += 4) {
      Place place;
      double x[4][3];
      for (std::size_t a = 0; a < 4; ++a) {
        place.nodes[a] = mesh.tets[e + a];
        std::copy_n(mesh.points.data() + 3 * static_cast<std::size_t>(place.nodes[a]), 3, x[a]);
      }
      const TetGeometry<double> g = tet_geometry(x);
      for (std::size_t a = 0; a < 4; ++a) {
        place.weight[a] = 0.25;
        for (std::size_t d = 0; d < 3; ++d)
          place.weight[a] +=
              g.gradient[a][d] * (probe.position[d] - 0.25 * (x[0][d] + x[1][d] + x[2][d] + x[3][d]));
      }
      const double smallest = *std::min_element(place.weight.begin(), place.weight.end());
      if (smallest > best_weight) {
        best_weight = smallest;
        best = place;
      }
    }
    if (best_weight < -1e-9)
      return config_error("probe \"{}\" at ({}, {}, {}) lies outside the fluid", probe.name,
                          probe.position[0], probe.position[1], probe.position[2]);
    probes.places_.push_back(best);
  }
  return probes;
}

std::vector<double> Probes::values(std::span<const double> u, std::span<const double> p,
                                   double density) const {
  std::vector<double> out;
  for (const Place& place : places_) {
    double v[4] = {};
    for (std::size_t a = 0; a < 4; ++a) {
      const auto node = static_cast<std::size_t>(place.nodes[a]);
      for (std::size_t d = 0; d < 3; ++d) v[d] += place.weight[a] * u[3 * node + d];
      v[3] += place.weight[a] * density * p[node];
    }
    out.insert(out.end(), v, v + 4);
  }
  return out;
}

} // namespace drogue::fluid
