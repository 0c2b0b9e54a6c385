// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/flow_fields.hpp"

#include <algorithm>
#include <cmath>

#include "fluid_solver/stabilisation.hpp"

namespace drogue::fluid {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

double length_of(const FluidMesh& mesh, double volume) {
  return mesh.dimension == 2 ? element_length<2>(volume) : element_length<3>(volume);
}

} // namespace

ElementState element_state(const Settings& settings, const FluidMesh& mesh, std::span<const double> x,
                           std::span<const double> u, std::int32_t cell) {
  ElementState s;
  const CellGeometry geometry = cell_geometry(mesh, x, cell);
  const auto nodes = mesh.cell(cell);
  s.volume = geometry.volume;
  for (std::size_t a = 0; a < nodes.size(); ++a)
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) s.grad_u[i][j] += u[3 * at(nodes[a]) + i] * geometry.gradient[a][j];
  s.eddy = eddy_viscosity<3>(length_of(mesh, s.volume), s.grad_u, settings.smagorinsky);
  s.nu = settings.kinematic_viscosity() + s.eddy;
  return s;
}

FaceTraction face_traction(const Settings& settings, const FluidMesh& mesh, std::span<const double> x,
                           std::span<const double> u, std::span<const double> p, const BoundaryFace& face) {
  FaceTraction t;
  const auto a = area_vector(face, x);
  t.area = std::hypot(a[0], a[1], a[2]);
  if (t.area == 0) return t;
  const ElementState s = element_state(settings, mesh, x, u, face.cell);
  double mean = 0;
  for (const std::int32_t node : face.nodes()) mean += p[at(node)] / static_cast<double>(face.corners);
  for (std::size_t i = 0; i < 3; ++i) {
    t.pressure[i] = mean * a[i] / t.area;
    for (std::size_t j = 0; j < 3; ++j)
      t.viscous[i] -= s.nu * (s.grad_u[i][j] + s.grad_u[j][i]) * a[j] / t.area;
  }
  return t;
}

NodalFields nodal_fields(const Settings& settings, const FluidMesh& mesh, std::span<const double> x,
                         std::span<const double> u) {
  const std::size_t n = at(mesh.node_count());
  NodalFields f{std::vector<double>(3 * n), std::vector<double>(n), std::vector<double>(n)};
  std::vector<double> volume(n);
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
    const ElementState s = element_state(settings, mesh, x, u, e);
    const auto& g = s.grad_u;
    const double w[3] = {g[2][1] - g[1][2], g[0][2] - g[2][0], g[1][0] - g[0][1]};
    double q = 0;
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) q -= 0.5 * g[i][j] * g[j][i];
    for (const std::int32_t corner : mesh.cell(e)) {
      const std::size_t node = at(corner);
      volume[node] += s.volume;
      f.q[node] += s.volume * q;
      f.eddy[node] += s.volume * s.eddy;
      for (std::size_t d = 0; d < 3; ++d) f.vorticity[3 * node + d] += s.volume * w[d];
    }
  }
  for (std::size_t i = 0; i < n; ++i) {
    f.q[i] /= volume[i];
    f.eddy[i] /= volume[i];
    for (std::size_t d = 0; d < 3; ++d) f.vorticity[3 * i + d] /= volume[i];
  }
  return f;
}

double largest_cfl(const FluidMesh& mesh, std::span<const double> x, std::span<const double> u, double dt) {
  double largest = 0;
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
    double speed = 0;
    for (const std::int32_t node : mesh.cell(e)) {
      const double* v = u.data() + 3 * at(node);
      speed = std::max(speed, std::hypot(v[0], v[1], v[2]));
    }
    largest = std::max(largest, speed * dt / length_of(mesh, cell_geometry(mesh, x, e).volume));
  }
  return largest;
}

double mass_imbalance(const FluidMesh& mesh, std::span<const double> x, std::span<const double> u) {
  double net = 0;
  double gross = 0;
  for (const BoundaryFace& face : mesh.faces) {
    const auto a = area_vector(face, x);
    double flux = 0;
    for (const std::int32_t node : face.nodes())
      for (std::size_t d = 0; d < 3; ++d)
        flux += u[3 * at(node) + d] * a[d] / static_cast<double>(face.corners);
    net += flux;
    gross += std::fabs(flux);
  }
  return gross > 0 ? 2 * net / gross : 0;
}

std::vector<double> nodal_traction(const Settings& settings, const FluidMesh& mesh, std::span<const double> x,
                                   std::span<const double> u, std::span<const double> p,
                                   std::span<const std::int32_t> boundaries,
                                   std::span<const std::int32_t> nodes) {
  std::vector<double> traction(3 * nodes.size());
  std::vector<double> area(nodes.size());
  for (const BoundaryFace& face : mesh.faces) {
    if (std::find(boundaries.begin(), boundaries.end(), face.boundary) == boundaries.end()) continue;
    const FaceTraction t = face_traction(settings, mesh, x, u, p, face);
    const auto a = area_vector(face, x);
    for (const std::int32_t node : face.nodes()) {
      const auto k =
          static_cast<std::size_t>(std::lower_bound(nodes.begin(), nodes.end(), node) - nodes.begin());
      area[k] += t.area;
      for (std::size_t d = 0; d < 3; ++d) traction[3 * k + d] += p[at(node)] * a[d] + t.area * t.viscous[d];
    }
  }
  for (std::size_t k = 0; k < nodes.size(); ++k)
    for (std::size_t d = 0; d < 3; ++d)
      if (area[k] > 0) traction[3 * k + d] /= area[k];
  return traction;
}

} // namespace drogue::fluid
