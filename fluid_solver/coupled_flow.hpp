// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "common/base/result.hpp"
#include "fluid_solver/flow_run.hpp"

namespace drogue::fluid {

/// What the coupler asks for, in a form that goes to every rank.
struct Order {
  enum class Kind : std::uint64_t {
    configure,
    initialize,
    begin_step,
    iterate,
    commit,
    rollback,
    checkpoint,
    restore,
    replace_mesh,
    stop
  };
  Kind kind = Kind::stop;
  /// configure: 1 or 0 (resume). begin_step: time, dt, step. iterate: 1 or 0 (velocity_start given), mesh
  /// displacement, velocity, velocity_start. commit: 1 or 0 (write fields). replace_mesh: 1 or 0 (restoring).
  std::vector<double> numbers;
  std::string text; ///< a directory; replace_mesh: the mesh's hash, a line break, its file
};

/// Rank 0's order on every rank; the others wait asleep. @note Collective
void broadcast(Order& order);

/// The flow in a coupled run. Every rank executes the same orders.
class CoupledFlow {
 public:
  /// `input` must outlive this; its mesh may be replaced.
  explicit CoupledFlow(Case& input);

  /// Errors: as FlowRun and FlowSolver. @note Collective
  [[nodiscard]] Result<void> execute(const Order& order);

  [[nodiscard]] const NewtonReport& last_report() const { return report_; }
  /// Of the last replace_mesh.
  [[nodiscard]] const TransferDefects& last_defects() const { return defects_; }
  /// Interface nodes in the mesh file's numbers, ascending; all interface fields follow this order.
  [[nodiscard]] const std::vector<std::int32_t>& interface_file_nodes() const {
    return interface_file_nodes_;
  }
  /// Positions at Initialize, or in the mesh that has replaced the first, mesh file's order.
  [[nodiscard]] std::vector<double> initial_points() const {
    return input_.mesh.reordered_to_file(base_points_, 3);
  }
  /// Load at t_{n+1}^-: pressure {n} or traction {n, 3}, as the settings say; and the slab's mean pressure
  /// {n}.
  [[nodiscard]] Result<std::vector<double>> load() const;
  [[nodiscard]] std::vector<double> mean_pressure() const;
  /// The slab's mean traction {n, 3}, made as the settings say. @pre the load is a traction
  [[nodiscard]] Result<std::vector<double>> mean_traction() const;

 private:
  [[nodiscard]] Result<void> initialize();
  [[nodiscard]] Result<void> iterate(const std::vector<double>& numbers);
  [[nodiscard]] Result<void> restore(const std::string& directory);
  [[nodiscard]] Result<std::vector<double>> traction(const std::vector<double>& u,
                                                     const std::vector<double>& p,
                                                     const std::vector<double>& forces) const;

  void find_interface();
  [[nodiscard]] Result<void> replace_mesh(const Order& order);

  Case& input_;
  FlowRun run_;
  std::vector<std::int32_t> interface_file_nodes_;
  std::vector<double> base_points_; ///< solver's order
  NewtonReport report_;
  TransferDefects defects_;
  std::vector<double> forces_, mean_forces_; ///< nodal, of the last iterate, for the consistent traction
  bool resume_ = false;
  bool advanced_ = false; ///< a step was committed, or restored: there is something to write at the end
};

} // namespace drogue::fluid
