// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "common/base/worker_pool.hpp"
#include "structure_solver/block_matrix.hpp"
#include "structure_solver/load_values.hpp"
#include "structure_solver/model.hpp"
#include "structure_solver/work_split.hpp"

namespace drogue::structure {

/// Sums the kernels into the residual and the tangent, with several threads. The result does not depend on
/// their number (see WorkSplit).
class Assembler {
 public:
  /// @param threads 0: default_threads(), fewer for small models. @pre `model` outlives the assembler
  explicit Assembler(const Model& model, int threads = 0);

  struct Request {
    /// {3 nodes}: the displacement at which the elements are evaluated [length].
    std::span<const double> displacement;
    /// The same for follower pressure.
    std::span<const double> load_displacement;
    const LoadValues& loads;
    /// Fill tangent(), multiplied by tangent_scale.
    bool tangent = false;
    double tangent_scale = 1;
    /// The same for the load stiffness.
    double load_scale = 1;
    /// With the load stiffness of follower pressures.
    bool load_stiffness = false;
  };

  /// residual = f_int - f_ext [force], {3 nodes}; without inertia. Returns the stored energy.
  double assemble(const Request& request, std::span<double> residual);
  /// f_ext at a displacement [force], {3 nodes}; without drag.
  void external_force(std::span<const double> displacement, const LoadValues& loads, std::span<double> force);

  /// Adds `value` to the diagonal of a node, after assemble().
  void add_to_diagonal(std::int32_t node, double value) noexcept { tangent_.add_diagonal(node, value); }
  /// Adds a block at (row, column), after assemble(). @pre an element couples the two nodes
  void add_block(std::int32_t row, std::int32_t column, const Eigen::Matrix3d& block) noexcept;
  /// Puts identity rows and columns where equations are held.
  void eliminate_held() noexcept { tangent_.eliminate_marked(); }
  [[nodiscard]] const la::SparseMatrix& tangent() const { return tangent_.matrix(); }

 private:
  /// One worker's share of the elements, of the follower pressures.
  void add_elements(int worker, const Request& request, std::span<double> residual);
  void add_pressure(int worker, const Request& request, std::span<double> residual);
  /// Adds an element's response to the worker's own equations. `slot` points to the element's slots.
  template <int Nodes>
  void scatter(int worker, const Response<Nodes>& response, const std::int32_t* nodes,
               std::span<double> residual) const noexcept;
  template <int Nodes>
  void scatter_tangent(int worker, const Response<Nodes>& response, const std::int32_t* nodes,
                       const std::int32_t* slot, double scale) noexcept;

  const Model& model_;
  BlockMatrix tangent_;
  WorkerPool pool_;
  WorkSplit split_;
  /// Slots of each element's blocks, {count, column node, row node}, for every batch and pressure batch.
  std::vector<std::vector<std::int32_t>> batch_slots_;
  std::vector<std::vector<std::int32_t>> pressure_slots_;
  /// Of every element of every batch: summed in one order.
  std::vector<std::vector<double>> energy_;
};

} // namespace drogue::structure
