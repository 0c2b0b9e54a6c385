// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "common/meshing/simplex_locator.hpp"
#include "fluid_solver/fluid_mesh.hpp"

namespace drogue::fluid {

/// Carries nodal fields from one mesh to another one of the same domain with the same boundary triangulation
/// (in the plane: division of the boundary into edges). Nodes that both have keep their values: those of the
/// boundary, the k-th of the one (in the order of its file) being the k-th of the other, and those that the
/// new file's field "previous" (common/meshing/remesh.hpp) names.
class MeshTransfer {
 public:
  /// All three must outlive this. Errors (ErrorKind::config): the boundaries or dimensions differ.
  /// @param x {n, 3}: where the nodes of `from` are; those of `to` are at to.points
  [[nodiscard]] static Result<MeshTransfer> create(const FluidMesh& from, std::span<const double> x,
                                                   const FluidMesh& to);

  /// Values {n, components} at the nodes that were kept, zero at the new ones.
  [[nodiscard]] std::vector<double> at_kept_nodes(std::span<const double> values, int components) const;
  /// Values of the old field at the new nodes.
  [[nodiscard]] std::vector<double> interpolated(std::span<const double> values, int components) const;

  /// The field nearest to the old one among those that equal it at kept nodes and have its integral:
  ///   int w_a (u_new - u_old) = lambda int w_a   for all new nodes a,   int (u_new - u_old) = 0,
  /// the first integral by 14 points in each new tetrahedron (7 in a triangle), the last one exactly; lambda,
  /// a constant for each component, is the quadrature's error. Linear fields are reproduced to rounding.
  /// Errors (ErrorKind::numerical): a quadrature point lies in no old cell; conjugate gradients do not
  /// converge.
  [[nodiscard]] Result<std::vector<double>> projected(std::span<const double> values, int components) const;

 private:
  MeshTransfer(const FluidMesh& from, std::span<const double> x, const FluidMesh& to);
  [[nodiscard]] Result<void> pair_nodes(std::span<const double> x);
  template <std::size_t D>
  [[nodiscard]] std::vector<std::array<std::int32_t, D + 1>> old_cells() const;
  template <std::size_t D>
  void interpolate(std::span<const double> values, std::size_t width, std::vector<double>& out) const;
  template <std::size_t D>
  [[nodiscard]] Result<std::vector<double>> load(std::span<const double> values, std::size_t width) const;

  const FluidMesh& from_;
  const FluidMesh& to_;
  std::vector<meshing::Point> points_;            ///< of `from`
  std::vector<std::int32_t> kept_from_, kept_to_; ///< node by node the same
  std::vector<char> is_kept_;                     ///< of `to`
};

/// int f over the mesh of each component of a nodal field {n, components}, the mesh's nodes at x {n, 3}.
[[nodiscard]] std::vector<double> integral(const FluidMesh& mesh, std::span<const double> x,
                                           std::span<const double> values, int components);

/// Integral magnitudes by which changes of a flow are measured.
struct FlowTotals {
  double momentum[3] = {}; ///< int u
  double speed = 0;        ///< int |u|, by nodes
  double energy = 0;       ///< int u.u / 2
  double net_flux = 0;     ///< int u.n over the boundary
  double gross_flux = 0;   ///< int |u.n|, by faces
};
[[nodiscard]] FlowTotals flow_totals(const FluidMesh& mesh, std::span<const double> x,
                                     std::span<const double> u);

} // namespace drogue::fluid
