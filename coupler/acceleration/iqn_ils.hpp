// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <deque>
#include <memory>

#include "coupler/acceleration/accelerator.hpp"

namespace drogue::acceleration {

/// Interface quasi-Newton with an inverse Jacobian from a least-squares model [degroote2009].
///
/// Columns, newest first:  dr_j = r_j - r_{j-1},  dh_j = h_j - h_{j-1},  within one step; those of the last
/// `reuse_steps` steps are kept.
///   c = arg min | r + sum_j c_j dr_j |,   x_next = h + sum_j c_j dh_j,   passenger likewise.
/// Without any column: constant relaxation.
///
/// Filter: with dr = Q R in the order newest first, column j is dropped when R_jj < filter |dr_j|
/// [haelterman2016, QR2]. R is the Cholesky factor of the Gram matrix, of which every iteration adds one row,
/// and the least squares are solved by the semi-normal equations with one correction: O(m n) an iteration in
/// place of O(m^2 n). The squared ratio is resolved down to 1e-13, so a filter below 3e-7 acts as 3e-7.
class IqnIls final : public Accelerator {
 public:
  IqnIls(const Settings& settings, std::span<const double> weights, std::size_t n, std::size_t passenger);
  void begin_step() override;
  [[nodiscard]] bool next(const Iterate& at, std::span<double> x_next,
                          std::span<double> passenger_next) override;
  void end_step(bool converged) override;
  void rollback() override;
  [[nodiscard]] State save() const override;
  [[nodiscard]] Result<void> restore(const State& state) override;
  [[nodiscard]] int used_columns() const override { return static_cast<int>(kept_.size()); }
  [[nodiscard]] int dropped_columns() const override { return dropped_; }

 private:
  struct Column {
    std::int64_t step = 0;
    std::vector<double> dr, dh, dp; ///< dr is scaled by the square roots of the weights
    /// Products of dr with this column (first) and the older ones, in the order of columns_ when it was
    /// added.
    std::vector<double> gram;
  };
  using Columns = std::deque<std::shared_ptr<const Column>>;

  [[nodiscard]] std::shared_ptr<const Column> make_column(const Iterate& at) const;
  [[nodiscard]] std::vector<double> products(const std::vector<double>& dr) const;
  void factor();
  void solve_normal_equations(std::vector<double>& b) const;
  [[nodiscard]] std::vector<double> least_squares() const;

  Settings settings_;
  std::vector<double> root_weights_;
  std::size_t passenger_;

  std::int64_t step_ = 0;
  Columns columns_;          ///< newest first
  Columns columns_at_begin_; ///< what rollback restores
  std::int64_t step_at_begin_ = 0;

  bool has_last_ = false;
  std::vector<double> r_, r_last_, h_last_, p_last_;
  std::vector<std::size_t> kept_; ///< indices of the columns that passed the filter
  std::vector<double> R_;         ///< packed by columns: R_ij at j (j + 1) / 2 + i
  int dropped_ = 0;
};

} // namespace drogue::acceleration
