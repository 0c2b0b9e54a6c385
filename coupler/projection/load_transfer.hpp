// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <span>
#include <vector>

#include "common/base/cache_lines.hpp"
#include "common/la_direct/direct_solver.hpp"
#include "coupler/projection/interface_quadrature.hpp"
#include "coupler/projection/projection_kernels.hpp"

namespace drogue::projection {

/// Sums over a surface: force, moment about the origin, and the power of the load on a velocity (zero without
/// one).
struct LoadSums {
  Eigen::Vector3d force = Eigen::Vector3d::Zero();
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  double power = 0;
};

/// State of the fluid surface. The velocity may be empty; it enters the sums alone.
struct FluidSide {
  std::span<const double> points;   ///< {fluid nodes, 3}: current positions [length]
  std::span<const double> velocity; ///< {fluid nodes, 3} or empty [velocity]
};

/// Loads, fluid -> structure, as nodal forces:
///   f_a = int over the current fluid surface of N_a(pi(x)) t da,    sum_a f_a = int t da to rounding
/// (the N_a add up to one wherever pi(x) lies). The two fluid sides of a canopy add up. pi is the closest
/// point in material coordinates and was located once; the fluid's area and normals are those of the
/// positions given.
///
/// Sign. n is the fluid surface's normal by its elements' node order (x_xi cross x_eta), and points out of
/// the fluid, into the wall. The pressure p of the fluid on the wall gives t = + p n: positive pressure
/// pushes the wall away from the fluid. (The fluid's own stress vector on that outward normal is -p n; the
/// wall gets its reaction.)
///
/// On linear fluid elements f_a = sum_b C_ab A t_b with A the element's current area and C_ab = int N_a(pi)
/// N_b, which no motion changes: 18 flops for each structure node that an element meets, on triangles with
/// vectors (projection_kernels.hpp). Curved elements are summed point by point. No heap; sums in a fixed
/// order.
class LoadTransfer {
 public:
  /// Errors (ErrorKind::internal): CHOLMOD; (ErrorKind::config): recovery matrix singular.
  [[nodiscard]] static Result<LoadTransfer> create(InterfaceQuadrature quadrature, const Surface& structure,
                                                   const Surface& fluid, bool recover_traction = true);

  /// t = + p n.  @param pressure {fluid nodes}  @param forces {structure nodes, 3}, overwritten
  /// @return sums over the fluid surface
  LoadSums from_pressure(const FluidSide& fluid, std::span<const double> pressure,
                         std::span<double> forces) noexcept;
  /// @param traction {fluid nodes, 3}: force on the wall per current area
  LoadSums from_traction(const FluidSide& fluid, std::span<const double> traction,
                         std::span<double> forces) noexcept;

  /// Traction of which the forces are the work-equivalent: int N_a t dA = f_a, per reference area, least
  /// squares in the points of the fluid, so that a load that is a field of the structure's elements is
  /// recovered to rounding. Where no fluid lies the load is zero and so is t, up to the transition of one
  /// element.
  /// @param forces {structure nodes, 3}  @param traction {structure nodes, 3}
  /// @pre create() was told to prepare it
  [[nodiscard]] Result<void> recover_traction(std::span<const double> forces, std::span<double> traction);

  /// The products of both directions.
  [[nodiscard]] const InterfaceQuadrature& quadrature() const { return quadrature_; }

 private:
  using TriangleKernel = FlatSums (*)(const FlatTriangles&, const FlatFluid&, const double*,
                                      double*) noexcept;
  template <class LineLoad, class LoadOn>
  LoadSums transfer(const FluidSide& fluid, TriangleKernel triangles, std::span<const double> load,
                    std::span<double> forces, const LineLoad& line_load, const LoadOn& load_on) noexcept;
  void sort_elements();
  /// A linear line's f_a += sum_b C_ab g_b, g_b the columns of G.
  void add_line(const InterfaceQuadrature::Element& element, const Eigen::Matrix<double, 3, 2>& G,
                std::span<double> forces) const noexcept;
  static void add_line_sums(const InterfaceQuadrature::Element& element, const Eigen::Matrix<double, 3, 2>& G,
                            const Eigen::Matrix<double, 3, 2>& X, const FluidSide& fluid,
                            LoadSums& sums) noexcept;
  void add_at_point(std::int64_t point, const Eigen::Vector3d& f, std::span<double> forces) const noexcept;
  [[nodiscard]] Result<void> factor_recovery(const Surface& structure, const Surface& fluid);

  InterfaceQuadrature quadrature_;
  std::size_t structure_nodes_ = 0;
  std::vector<std::int32_t> triangle_nodes_; ///< of the linear triangles
  std::vector<FlatTriangles::Rows> triangle_rows_;
  std::vector<std::int32_t> other_elements_;
  CacheLines<double> triangle_forces_; ///< {structure nodes, 4}; empty without triangles
  la::CholeskySolver M_{la::CholeskySolver::Use::many_solutions};
  std::vector<double> work_; ///< {3, structure nodes}
};

/// Sums of nodal forces. All {n, 3}; velocity may be empty.
[[nodiscard]] LoadSums sum_nodal(std::span<const double> points, std::span<const double> forces,
                                 std::span<const double> velocity = {}) noexcept;

/// Elements of the structure with less fluid on them than this share of their area count as dry.
inline constexpr double dry_share = 0.25;

} // namespace drogue::projection
