// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <deque>
#include <initializer_list>
#include <memory>

#include "coupler/acceleration/accelerator.hpp"

namespace drogue::acceleration {

/// Interface quasi-Newton with an inverse Jacobian from a least-squares model (IQN-ILS) [degroote2009], or
/// with the multi-vector one (IQN-IMVJ) [bogaers2014].
///
/// Columns, newest first:  dr_j = r_j - r_{j-1},  dh_j = h_j - h_{j-1},  within one step; those of the last
/// `reuse_steps` steps are kept.
///   c = arg min | r + sum_j c_j dr_j |,   x_next = h + sum_j c_j dh_j,   passenger likewise.
/// Without any column: constant relaxation.
///
/// IMVJ: the secants V_k (of dr), W_k (of dh) of each step k correct the inverse Jacobian of the steps
/// before,
///   J_k = J_{k-1} + (W_k - J_{k-1} V_k) V_k^+,  J = 0 before the oldest step kept,   x_next = h - J r.
/// No matrix is formed: J_k q = W_k a + J_{k-1} (q - V_k a) with a = V_k^+ q is one small least squares a
/// step, the newest first, on what the newer ones leave of -r. With all columns in one step it is IQN-ILS.
///
/// Filter: with dr = Q R in the order newest first, column j is dropped when R_jj < filter |dr_j|
/// [haelterman2016, QR2]. R is the Cholesky factor of the Gram matrix, of which every iteration adds one row,
/// and the least squares are solved by the semi-normal equations with one correction: O(m n) an iteration in
/// place of O(m^2 n). The squared ratio is resolved down to 1e-13, so a filter below 3e-7 acts as 3e-7.
///
/// The columns are many and long, and an iteration costs the reading of them. The dr are read twice (the new
/// one's row of the Gram matrix together with the products of r, and the correction), dh and dp once.
class IqnIls final : public Accelerator {
 public:
  IqnIls(const Settings& settings, std::span<const double> weights, std::size_t n, std::size_t passenger);
  void begin_step() override;
  [[nodiscard]] bool next(const Iterate& at, std::span<double> x_next,
                          std::span<double> passenger_next) override;
  void end_step(bool converged) override;
  void forget() override;
  void rollback() override;
  [[nodiscard]] State save() const override;
  [[nodiscard]] Result<void> restore(const State& state) override;
  [[nodiscard]] int used_columns() const override { return used_; }
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

  void add_column(const Iterate& at);
  [[nodiscard]] std::vector<std::vector<double>>
  products(std::initializer_list<std::span<const double>> vectors) const;
  void factor(std::size_t begin, std::size_t end);
  void solve_normal_equations(std::vector<double>& b) const;
  [[nodiscard]] std::vector<double> least_squares(std::size_t begin) const;
  [[nodiscard]] std::size_t end_of_group(std::size_t begin) const;
  [[nodiscard]] bool add_group(std::size_t begin, std::size_t end, std::span<double> x_next,
                               std::span<double> passenger_next);

  Settings settings_;
  std::vector<double> root_weights_;
  std::size_t passenger_;

  std::int64_t step_ = 0;
  Columns columns_;          ///< newest first
  Columns columns_at_begin_; ///< what rollback restores
  std::int64_t step_at_begin_ = 0;

  bool has_last_ = false;
  std::vector<double> of_r_; ///< products of r with the dr of columns_
  std::vector<double> rest_; ///< of r, what the columns used so far leave
  std::vector<double> r_, r_last_, h_last_, p_last_;
  std::vector<std::size_t> kept_; ///< indices of the columns of a group that passed the filter
  std::vector<double> R_;         ///< packed by columns: R_ij at j (j + 1) / 2 + i
  int used_ = 0, dropped_ = 0;
};

} // namespace drogue::acceleration
