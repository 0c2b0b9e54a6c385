// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/recovered_stress.hpp"

#include <algorithm>

#include "fluid_solver/instant.hpp"

namespace drogue::fluid {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

} // namespace

RecoveredStress::RecoveredStress(const FluidMesh& mesh, const la::RowRange& own) : mesh_(mesh) {
  std::vector<char> needed(at(mesh.node_count()), 0);
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
    const auto nodes = mesh.cell(e);
    if (std::any_of(nodes.begin(), nodes.end(), [&](std::int32_t i) { return own.has(i); }))
      for (const std::int32_t i : nodes) needed[at(i)] = 1;
  }
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
    const auto nodes = mesh.cell(e);
    if (std::any_of(nodes.begin(), nodes.end(), [&](std::int32_t i) { return needed[at(i)] != 0; }))
      cells_.push_back(e);
  }
}

void RecoveredStress::evaluate(std::span<const double> x, std::span<const double> u, std::size_t stride,
                               double nu, std::vector<double>& stress) {
  stress.assign(6 * at(mesh_.node_count()), 0.0);
  volume_.assign(at(mesh_.node_count()), 0.0);
  for (const std::int32_t e : cells_) {
    const CellGeometry geometry = cell_geometry(mesh_, x, e);
    const auto nodes = mesh_.cell(e);
    double grad_u[3][3] = {};
    for (std::size_t a = 0; a < nodes.size(); ++a) {
      const double* velocity = u.data() + stride * at(nodes[a]);
      for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) grad_u[i][j] += velocity[i] * geometry.gradient[a][j];
    }
    double s[6];
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j <= i; ++j)
        s[stress_component(i, j)] = geometry.volume * nu * (grad_u[i][j] + grad_u[j][i]);
    for (const std::int32_t node : nodes) {
      volume_[at(node)] += geometry.volume;
      for (std::size_t i = 0; i < 6; ++i) stress[6 * at(node) + i] += s[i];
    }
  }
  for (std::size_t i = 0; i < stress.size(); ++i)
    if (volume_[i / 6] > 0) stress[i] /= volume_[i / 6];
}

} // namespace drogue::fluid
