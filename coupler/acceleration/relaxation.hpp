// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "coupler/acceleration/accelerator.hpp"

namespace drogue::acceleration {

/// x_next = x + omega (H(x) - x) with one omega.
class ConstantRelaxation final : public Accelerator {
 public:
  explicit ConstantRelaxation(double omega) : omega_(omega) {}
  void begin_step() override {}
  [[nodiscard]] bool next(const Iterate& at, std::span<double> x_next,
                          std::span<double> passenger_next) override;
  void end_step(bool) override {}
  void forget() override {}
  void rollback() override {}
  [[nodiscard]] State save() const override { return {}; }
  [[nodiscard]] Result<void> restore(const State&) override { return {}; }

 private:
  double omega_;
};

/// x_next = x + omega_k r_k,  r = H(x) - x,  omega_k = -omega_{k-1} <r_{k-1}, r_k - r_{k-1}> / |r_k -
/// r_{k-1}|^2 [irons1969; kuettler2008]. The first omega of a step is the last one of the step
/// before, between half of the setting `relaxation` and `max_relaxation` (the setting itself after a step
/// that did not converge). When two residuals are equal to rounding, omega stays.
class AitkenRelaxation final : public Accelerator {
 public:
  AitkenRelaxation(const Settings& settings, std::span<const double> weights, std::size_t n);
  void begin_step() override;
  [[nodiscard]] bool next(const Iterate& at, std::span<double> x_next,
                          std::span<double> passenger_next) override;
  void end_step(bool converged) override;
  void forget() override;
  void rollback() override { omega_ = omega_at_begin_; }
  [[nodiscard]] State save() const override;
  [[nodiscard]] Result<void> restore(const State& state) override;
  [[nodiscard]] double omega() const { return omega_; }

 private:
  double relaxation_;
  double max_;
  std::vector<double> weights_;
  std::vector<double> r_, r_last_;
  double omega_;
  double omega_at_begin_;
  bool has_last_ = false;
};

/// y = a + omega (b - a); y may be a or b.
void relax(double omega, std::span<const double> a, std::span<const double> b, std::span<double> y) noexcept;

} // namespace drogue::acceleration
