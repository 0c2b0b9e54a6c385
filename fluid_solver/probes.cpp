// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/probes.hpp"

#include <algorithm>
#include <limits>

namespace drogue::fluid {

Result<Probes> Probes::create(const std::vector<ProbeSettings>& wanted, const FluidMesh& mesh) {
  Probes probes;
  for (const ProbeSettings& probe : wanted) {
    Place best;
    double best_weight = -std::numeric_limits<double>::infinity(); // smallest barycentric weight
    for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
      const auto nodes = mesh.cell(e);
      const CellGeometry g = cell_geometry(mesh, mesh.points, e);
      Place place;
      for (std::size_t a = 0; a < nodes.size(); ++a) {
        place.nodes[a] = nodes[a]; // N_a = 1 at its own node
        place.weight[a] = 1;
        for (std::size_t d = 0; d < 3; ++d)
          place.weight[a] += g.gradient[a][d] *
                             (probe.position[d] - mesh.points[3 * static_cast<std::size_t>(nodes[a]) + d]);
      }
      const double smallest = *std::min_element(place.weight.data(), place.weight.data() + nodes.size());
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

std::vector<std::array<double, 3>> Probes::positions(std::span<const double> x) const {
  std::vector<std::array<double, 3>> out;
  for (const Place& place : places_) {
    auto& position = out.emplace_back();
    for (std::size_t a = 0; a < 4; ++a)
      for (std::size_t d = 0; d < 3; ++d)
        position[d] += place.weight[a] * x[3 * static_cast<std::size_t>(place.nodes[a]) + d];
  }
  return out;
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
