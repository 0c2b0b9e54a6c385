// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "coupler/projection/interface.hpp"
#include "coupler/projection/surface_integrals.hpp"
#include "coupler/scheme/participants.hpp"
#include "coupler/scheme/results.hpp"

namespace drogue::coupler {

/// The structure's load is factor (f - withheld f_first), f the fluid's nodal forces, f_first those of the
/// first evaluation of the run.
struct LoadShare {
  double factor = 1, withheld = 0;
};

/// What travels in one coupling iteration, with all projections: d, v of the structure in, its load and the
/// fluid's motion out. Arrays {n, 3}.
class Exchange {
 public:
  /// Pairs the surfaces the participants gave. Errors (ErrorKind::config): the surfaces do not fit.
  [[nodiscard]] static Result<Exchange> create(Participants& participants, const CaseSettings& settings);

  /// One pass around the loop for the iterate (d, v): mesh mover, fluid, structure. Fills d_tilde and v_tilde
  /// and the record's forces and inner iterations.
  /// @param v_start wall velocity at t_n^+
  /// @param given_force nodal forces that the structure takes, while mesh mover and fluid work; empty: it
  /// waits
  ///        for the fluid's
  [[nodiscard]] Result<void> evaluate(const Station& at, LoadShare share, std::span<const double> d,
                                      std::span<const double> v, std::span<const double> v_start,
                                      std::span<const double> given_force, std::vector<double>& d_tilde,
                                      std::vector<double>& v_tilde, IterationRecord& record);
  /// The structure alone, under nodal forces; d is where its iteration starts.
  [[nodiscard]] Result<void> structure(const Station& at, std::span<const double> d,
                                       std::span<const double> force, std::vector<double>& d_tilde,
                                       std::vector<double>& v_tilde);
  /// Mesh mover and fluid alone: their load is then force().
  [[nodiscard]] Result<void> fluid(const Station& at, LoadShare share, std::span<const double> d,
                                   std::span<const double> v, std::span<const double> v_start,
                                   IterationRecord& record);
  /// From now on the structure takes f + weight (f - last), f the fluid's nodal forces: its means of the step
  /// and of the step before brought to the end of the step with the weight dt / (dt + dt_before).
  void extrapolate(std::span<const double> last, double weight);
  /// Nodal forces of the fluid's last solve before that, {n, 3} [force].
  [[nodiscard]] std::span<const double> given_force() const { return given_force_; }
  /// f_first of LoadShare, {n, 3} [force]; empty before the first evaluation.
  [[nodiscard]] const std::vector<double>& first_force() const { return first_force_; }
  void set_first_force(std::vector<double> force) { first_force_ = std::move(force); }
  /// Nodal forces for the structure, {n, 3} [force].
  [[nodiscard]] std::span<const double> force() const { return force_; }

  /// L2 norm on the structure's surface over the square root of its area, and area-weighted mean.
  [[nodiscard]] double norm(std::span<const double> field) const { return surface_.norm(field, 3); }
  [[nodiscard]] Vector3 mean(std::span<const double> field) const;
  /// int n dA over the structure's surface displaced by d.
  [[nodiscard]] Vector3 vector_area(std::span<const double> d) const;
  /// Lumped areas, one a node, for inner products.
  [[nodiscard]] std::span<const double> areas() const { return surface_.lumped_area(); }
  [[nodiscard]] std::size_t structure_size() const { return 3 * surface_.lumped_area().size(); }

 private:
  Exchange(Participants& participants, projection::Interface interface)
      : participants_(participants), interface_(std::move(interface)), surface_(interface_.structure) {}
  [[nodiscard]] Result<participant::FloatArray> move_mesh(const Station& at, std::span<const double> d,
                                                          IterationRecord& record);
  [[nodiscard]] Result<participant::FloatArray>
  solve_flow(const Station& at, participant::FloatArray mesh_displacement, std::span<const double> v_start);
  [[nodiscard]] Result<void> end_structure(std::vector<double>& d_tilde, std::vector<double>& v_tilde);
  void report(IterationRecord& record) const;
  [[nodiscard]] Result<participant::Fields> structure_inputs(std::span<const double> d,
                                                             std::span<const double> force);
  [[nodiscard]] Result<void> transfer_load(const participant::FloatArray& load, LoadShare share,
                                           std::span<const double> d, std::span<const double> v,
                                           IterationRecord& record);

  Participants& participants_;
  projection::Interface interface_;
  projection::SurfaceIntegrals surface_;
  bool outer_boundary_follows_ = true;
  std::vector<std::int64_t> to_mesh_mover_; ///< {n}: fluid interface node of each mesh mover interface node
  std::vector<double> fluid_d_, fluid_v_, fluid_x_, structure_x_, force_;
  std::vector<double> v_start_, fluid_v_start_;  ///< the last one projected, and what came of it
  std::vector<double> given_force_, last_force_; ///< last_force_ empty: force_ is given_force_
  double extrapolation_ = 0;
  std::vector<double> first_force_;
  std::vector<double> traction_; ///< empty unless the structure takes it
};

} // namespace drogue::coupler
