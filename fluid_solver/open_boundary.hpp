// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "common/la_krylov/block_matrix.hpp"
#include "fluid_solver/fluid_mesh.hpp"
#include "fluid_solver/settings.hpp"
#include "fluid_solver/step_data.hpp"

/// Terms on boundaries whose traction is given (zero or not); in two dimensions Gamma is made of edges:
///   F_a = - int_Gamma N_a t / rho  -  beta int_Gamma N_a min((u - mesh velocity) . n, 0) u
/// t: prescribed traction [stress]; beta: backflow factor, 1/2 cancels the kinetic energy that inflow through
/// an open boundary brings in [bazilevs2009]. Quadrature: face_rule.hpp; nothing is held constant in the
/// tangent.
namespace drogue::fluid {

class OpenBoundary {
 public:
  OpenBoundary(const Settings& settings, const FluidMesh& mesh, const la::RowRange& own,
               const la::LocalPattern& pattern);

  /// Adds to own rows as add_elements does.
  template <int unknowns>
  void add(const StepData& data, std::span<const double, unknowns> scale, std::span<double> residual,
           la::BlockMatrix<unknowns>* jacobian) const;

 private:
  struct Face {
    BoundaryFace face;
    std::int32_t boundary = 0;     ///< index into boundaries_
    std::int32_t row[3] = {};      ///< own row, or -1
    std::int32_t entry[3][3] = {}; ///< position in the pattern, or -1
  };
  struct Terms;
  template <int unknowns, int points>
  void add_with(const StepData& data, std::span<const double, unknowns> scale, std::span<double> residual,
                la::BlockMatrix<unknowns>* jacobian) const;
  [[nodiscard]] Terms evaluate(const Face& face, const StepData& data, std::size_t unknowns,
                               double theta) const;

  std::vector<BoundarySettings> boundaries_;
  std::vector<Face> faces_;
  double density_;
};

} // namespace drogue::fluid
