// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/mesh_transfer.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "common/fem/quadrature.hpp"
#include "common/meshing/remesh.hpp"

namespace drogue::fluid {
namespace {

std::size_t at(std::int32_t i) {
  return static_cast<std::size_t>(i);
}

constexpr int quadrature_degree = 5;
/// Smallest barycentric coordinate of a quadrature point that still counts as inside: boundaries are equal to
/// rounding.
constexpr double outside = -1e-6;
constexpr double tolerance = 1e-13; ///< of conjugate gradients; the matrix is as good as diagonal
constexpr int max_iterations = 500;

/// Nodes of the boundary in the order of the file.
std::vector<std::int32_t> boundary_nodes(const FluidMesh& mesh) {
  std::vector<std::int32_t> all(mesh.boundaries.size());
  std::iota(all.begin(), all.end(), 0);
  std::vector<std::int32_t> nodes = mesh.nodes_of(all);
  std::sort(nodes.begin(), nodes.end(),
            [&](std::int32_t a, std::int32_t b) { return mesh.to_file[at(a)] < mesh.to_file[at(b)]; });
  return nodes;
}

/// Barycentric coordinates of quadrature points in a cell, and their weights, which add up to 1.
template <std::size_t D>
struct CellPoint {
  std::array<double, D + 1> N;
  double weight = 0;
};
template <std::size_t D>
std::vector<CellPoint<D>> cell_rule() {
  std::vector<CellPoint<D>> points;
  if constexpr (D == 2)
    for (const auto& q : fem::surface_quadrature(mesh::ElementKind::tri3, quadrature_degree))
      points.push_back({{1 - q.xi - q.eta, q.xi, q.eta}, 2 * q.weight});
  else
    for (const auto& q : fem::volume_quadrature(mesh::ElementKind::tet4, quadrature_degree))
      points.push_back({{1 - q.xi[0] - q.xi[1] - q.xi[2], q.xi[0], q.xi[1], q.xi[2]}, 6 * q.weight});
  return points;
}

/// The mass matrix between new nodes, element by element: of a cell with n nodes
///   int N_a N_b = V (1 + delta_ab) / (n (n + 1)).
class FreeMass {
 public:
  FreeMass(const FluidMesh& mesh, const std::vector<char>& is_kept)
      : mesh_(mesh), is_kept_(is_kept), lumped_(at(mesh.node_count()), 0.0) {
    for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
      const double V = cell_geometry(mesh, mesh.points, e).volume;
      volume_.push_back(V);
      for (const std::int32_t node : mesh.cell(e))
        lumped_[at(node)] += V / static_cast<double>(mesh.cell_nodes());
    }
  }
  /// int N_a.
  [[nodiscard]] const std::vector<double>& lumped() const { return lumped_; }
  /// y = M x, zero at kept nodes.
  void apply(const std::vector<double>& x, std::size_t width, std::vector<double>& y) const {
    std::fill(y.begin(), y.end(), 0.0);
    const auto n = static_cast<double>(mesh_.cell_nodes());
    for (std::int32_t e = 0; e < mesh_.cell_count(); ++e) {
      const auto cell = mesh_.cell(e);
      const double m = volume_[at(e)] / (n * (n + 1));
      for (std::size_t k = 0; k < width; ++k) {
        double sum = 0;
        for (const std::int32_t node : cell) sum += x[width * at(node) + k];
        for (const std::int32_t node : cell) y[width * at(node) + k] += m * (sum + x[width * at(node) + k]);
      }
    }
    clear_kept(width, y);
  }
  void clear_kept(std::size_t width, std::vector<double>& y) const {
    for (std::size_t i = 0; i < is_kept_.size(); ++i)
      if (is_kept_[i]) std::fill_n(y.begin() + static_cast<std::ptrdiff_t>(width * i), width, 0.0);
  }
  /// Solves M x = b over the new nodes, x from zero: conjugate gradients, scaled by int N_a, whose condition
  /// is below 5 whatever the mesh [wathen1987]; all components by themselves.
  [[nodiscard]] Result<std::vector<double>> solve(std::vector<double> b, std::size_t width) const {
    clear_kept(width, b);
    std::vector<double> x(b.size(), 0.0), r = std::move(b), z(x.size()), p(x.size(), 0.0), q(x.size());
    std::vector<double> rz(width, 0.0), first(width, 0.0);
    const auto dot = [&](const std::vector<double>& a, const std::vector<double>& c) {
      std::vector<double> sum(width, 0.0);
      for (std::size_t i = 0; i < a.size(); ++i) sum[i % width] += a[i] * c[i];
      return sum;
    };
    for (int k = 0; k < max_iterations; ++k) {
      for (std::size_t i = 0; i < r.size(); ++i) z[i] = r[i] / lumped_[i / width];
      const std::vector<double> next = dot(r, z);
      if (k == 0) first = next;
      bool done = true;
      for (std::size_t c = 0; c < width; ++c) done = done && next[c] <= tolerance * tolerance * first[c];
      if (done) return x;
      for (std::size_t i = 0; i < p.size(); ++i) {
        const std::size_t c = i % width;
        p[i] = z[i] + (k > 0 && rz[c] > 0 ? next[c] / rz[c] : 0.0) * p[i];
      }
      apply(p, width, q);
      const std::vector<double> pq = dot(p, q);
      for (std::size_t i = 0; i < p.size(); ++i) {
        const std::size_t c = i % width;
        const double alpha = pq[c] > 0 ? next[c] / pq[c] : 0;
        x[i] += alpha * p[i];
        r[i] -= alpha * q[i];
      }
      rz = next;
    }
    return numerical_error("the projection onto the new mesh did not converge in {} iterations",
                           max_iterations);
  }

 private:
  const FluidMesh& mesh_;
  const std::vector<char>& is_kept_;
  std::vector<double> volume_, lumped_;
};

} // namespace

MeshTransfer::MeshTransfer(const FluidMesh& from, std::span<const double> x, const FluidMesh& to)
    : from_(from), to_(to), is_kept_(at(to.node_count()), 0) {
  for (std::size_t i = 0; i < x.size(); i += 3) points_.emplace_back(x[i], x[i + 1], x[i + 2]);
}

/// Pairs the boundary's nodes in their order, and the others that the file says were there before.
Result<void> MeshTransfer::pair_nodes(std::span<const double> x) {
  kept_from_ = boundary_nodes(from_);
  kept_to_ = boundary_nodes(to_);
  if (kept_to_.size() != kept_from_.size() || from_.faces.size() != to_.faces.size())
    return config_error("the new mesh has {} nodes and {} faces on its boundary, the old one {} and {}",
                        kept_to_.size(), to_.faces.size(), kept_from_.size(), from_.faces.size());
  for (const std::int32_t node : kept_to_) is_kept_[at(node)] = 1;
  const auto previous = to_.file.node_fields.find(meshing::previous_field_name);
  if (previous != to_.file.node_fields.end())
    for (std::size_t i = 0; i < previous->second.values.size(); ++i) {
      const double old = previous->second.values[i];
      const std::int32_t node = to_.from_file[i];
      if (!(old >= 0) || !(old < from_.node_count()) || is_kept_[at(node)]) continue;
      is_kept_[at(node)] = 1;
      kept_to_.push_back(node);
      kept_from_.push_back(from_.from_file[static_cast<std::size_t>(old)]);
    }
  for (std::size_t k = 0; k < kept_to_.size(); ++k)
    for (std::size_t d = 0; d < 3; ++d)
      if (to_.points[3 * at(kept_to_[k]) + d] != x[3 * at(kept_from_[k]) + d])
        return config_error("node {} of the new mesh is not where that of the old one is",
                            to_.to_file[at(kept_to_[k])]);
  return {};
}

Result<MeshTransfer> MeshTransfer::create(const FluidMesh& from, std::span<const double> x,
                                          const FluidMesh& to) {
  if (from.dimension != to.dimension)
    return config_error("the new mesh has {} dimensions, the old one {}", to.dimension, from.dimension);
  MeshTransfer t(from, x, to);
  DROGUE_TRY(t.pair_nodes(x));
  return t;
}

std::vector<double> MeshTransfer::at_kept_nodes(std::span<const double> values, int components) const {
  const auto width = static_cast<std::size_t>(components);
  std::vector<double> out(width * at(to_.node_count()), 0.0);
  for (std::size_t k = 0; k < kept_to_.size(); ++k)
    std::copy_n(values.data() + width * at(kept_from_[k]), width, out.data() + width * at(kept_to_[k]));
  return out;
}

template <std::size_t D>
std::vector<std::array<std::int32_t, D + 1>> MeshTransfer::old_cells() const {
  std::vector<std::array<std::int32_t, D + 1>> cells(at(from_.cell_count()));
  for (std::size_t e = 0; e < cells.size(); ++e)
    std::copy_n(from_.cell(static_cast<std::int32_t>(e)).begin(), D + 1, cells[e].begin());
  return cells;
}

std::vector<double> MeshTransfer::interpolated(std::span<const double> values, int components) const {
  std::vector<double> out = at_kept_nodes(values, components);
  const auto width = static_cast<std::size_t>(components);
  from_.dimension == 2 ? interpolate<2>(values, width, out) : interpolate<3>(values, width, out);
  return out;
}

/// Fills in the new nodes.
template <std::size_t D>
void MeshTransfer::interpolate(std::span<const double> values, std::size_t width,
                               std::vector<double>& out) const {
  const auto cells = old_cells<D>();
  const meshing::SimplexLocator<D> locator(points_, cells);
  meshing::SimplexPlace<D> place;
  for (std::size_t i = 0; i < is_kept_.size(); ++i) {
    if (is_kept_[i]) continue;
    const double* x = to_.points.data() + 3 * i;
    place = locator.find({x[0], x[1], x[2]}, place.cell);
    if (place.cell < 0) continue;
    for (std::size_t a = 0; a <= D; ++a)
      for (std::size_t k = 0; k < width; ++k)
        out[width * i + k] += place.weight[a] * values[width * at(cells[at(place.cell)][a]) + k];
  }
}

/// int N_a u_old for the new nodes, over the cells that have one.
template <std::size_t D>
Result<std::vector<double>> MeshTransfer::load(std::span<const double> values, std::size_t width) const {
  const auto cells = old_cells<D>();
  const meshing::SimplexLocator<D> locator(points_, cells);
  const auto rule = cell_rule<D>();
  std::vector<double> b(width * at(to_.node_count()), 0.0), u(width);
  meshing::SimplexPlace<D> place;
  for (std::int32_t e = 0; e < to_.cell_count(); ++e) {
    const auto cell = to_.cell(e);
    if (std::all_of(cell.begin(), cell.end(), [&](std::int32_t node) { return is_kept_[at(node)] != 0; }))
      continue;
    const double V = cell_geometry(to_, to_.points, e).volume;
    for (const CellPoint<D>& q : rule) {
      meshing::Point x = meshing::Point::Zero();
      for (std::size_t a = 0; a <= D; ++a)
        for (int d = 0; d < 3; ++d)
          x[d] += q.N[a] * to_.points[3 * at(cell[a]) + static_cast<std::size_t>(d)];
      place = locator.find(x, place.cell);
      if (place.smallest() < outside)
        return numerical_error("({:.6g}, {:.6g}, {:.6g}) of the new mesh lies outside the old one", x[0],
                               x[1], x[2]);
      std::fill(u.begin(), u.end(), 0.0);
      for (std::size_t a = 0; a <= D; ++a)
        for (std::size_t k = 0; k < width; ++k)
          u[k] += place.weight[a] * values[width * at(cells[at(place.cell)][a]) + k];
      for (std::size_t a = 0; a <= D; ++a)
        for (std::size_t k = 0; k < width; ++k) b[width * at(cell[a]) + k] += q.weight * V * q.N[a] * u[k];
    }
  }
  return b;
}

Result<std::vector<double>> MeshTransfer::projected(std::span<const double> values, int components) const {
  const auto width = static_cast<std::size_t>(components);
  auto b = from_.dimension == 2 ? load<2>(values, width) : load<3>(values, width);
  if (!b) return b;
  const FreeMass mass(to_, is_kept_);
  // 1. what the kept values contribute goes to the right-hand side
  std::vector<double> u = at_kept_nodes(values, components), Mu(u.size());
  mass.apply(u, width, Mu);
  for (std::size_t i = 0; i < Mu.size(); ++i) (*b)[i] -= Mu[i];
  const auto inner = mass.solve(std::move(*b), width);
  if (!inner) return inner;
  for (std::size_t i = 0; i < u.size(); ++i) u[i] += (*inner)[i];
  // 2. the integral is that of the old field
  std::vector<double> x_old;
  for (const meshing::Point& x : points_) x_old.insert(x_old.end(), x.begin(), x.end());
  const auto w = mass.solve(mass.lumped(), 1);
  if (!w) return w;
  double weight = 0;
  for (std::size_t i = 0; i < w->size(); ++i) weight += (*w)[i] * mass.lumped()[i];
  if (!(weight > 0)) return u; // no new nodes
  const std::vector<double> wanted = integral(from_, x_old, values, components);
  const std::vector<double> got = integral(to_, to_.points, u, components);
  for (std::size_t i = 0; i < w->size(); ++i)
    for (std::size_t k = 0; k < width; ++k) u[width * i + k] += (*w)[i] * (wanted[k] - got[k]) / weight;
  return u;
}

std::vector<double> integral(const FluidMesh& mesh, std::span<const double> x, std::span<const double> values,
                             int components) {
  const auto width = static_cast<std::size_t>(components);
  std::vector<double> sum(width, 0.0);
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
    const auto cell = mesh.cell(e);
    const double share = cell_geometry(mesh, x, e).volume / static_cast<double>(cell.size());
    for (const std::int32_t node : cell)
      for (std::size_t k = 0; k < width; ++k) sum[k] += share * values[width * at(node) + k];
  }
  return sum;
}

FlowTotals flow_totals(const FluidMesh& mesh, std::span<const double> x, std::span<const double> u) {
  FlowTotals t;
  const auto nodes = static_cast<double>(mesh.cell_nodes());
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
    const auto cell = mesh.cell(e);
    const double V = cell_geometry(mesh, x, e).volume;
    double sum[3] = {}, squares = 0;
    for (const std::int32_t node : cell) {
      const double* v = u.data() + 3 * at(node);
      t.speed += V / nodes * std::hypot(v[0], v[1], v[2]);
      for (std::size_t d = 0; d < 3; ++d) {
        sum[d] += v[d];
        squares += v[d] * v[d];
      }
    }
    for (std::size_t d = 0; d < 3; ++d) t.momentum[d] += V / nodes * sum[d];
    t.energy +=
        0.5 * V / (nodes * (nodes + 1)) * (squares + sum[0] * sum[0] + sum[1] * sum[1] + sum[2] * sum[2]);
  }
  for (const BoundaryFace& face : mesh.faces) {
    const std::array<double, 3> n = area_vector(face, x);
    double flux = 0;
    for (const std::int32_t node : face.nodes())
      for (std::size_t d = 0; d < 3; ++d)
        flux += u[3 * at(node) + d] * n[d] / static_cast<double>(face.corners);
    t.net_flux += flux;
    t.gross_flux += std::abs(flux);
  }
  return t;
}

} // namespace drogue::fluid
