// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "common/base/result.hpp"

/// Accelerators of the fixed-point iteration x -> H(x): constant under-relaxation, Aitken's dynamic
/// relaxation, and the interface quasi-Newton methods with an inverse Jacobian from a least-squares model
/// (IQN-ILS) and from many (IQN-IMVJ).
namespace drogue::acceleration {

enum class Method { constant, aitken, iqn_ils, iqn_imvj };

struct Settings {
  Method method = Method::iqn_ils;
  /// Factor of the constant relaxation, and of the first relaxation of the other two.
  double relaxation = 0.05;
  /// Aitken: bound of the factor's magnitude.
  double max_relaxation = 1;
  /// IQN: number of past steps whose columns are kept.
  int reuse_steps = 20;
  /// IQN: a column is dropped when its part orthogonal to the newer ones is below this fraction of it.
  double filter = 1e-3;
  /// IQN: the oldest columns beyond this number are dropped.
  int max_columns = 300;
};

/// What an accelerator carries from one step to the next; plain, for checkpoints.
struct State {
  std::int64_t step = 0;
  double omega = 0;
  /// IQN, newest column first, shapes {columns}, {columns, n}, {columns, n} and {columns, passenger
  /// size}.
  std::vector<std::int64_t> column_step;
  std::vector<double> column_dr;
  std::vector<double> column_dh;
  std::vector<double> column_dp;
};

/// One point of the iteration. All of shape {n}, the passenger's of shape {passenger size}.
/// The passenger is a second field that belongs to x (the velocity of a displacement) and gets the same
/// affine combination as x; it does not influence the combination.
struct Iterate {
  std::span<const double> x;
  std::span<const double> h; ///< H(x)
  std::span<const double> x_passenger{};
  std::span<const double> h_passenger{};
};

///   begin_step --next--> ... --next--> end_step        (begin_step ... rollback: as if begin_step had not
///   been called)
///
/// Deterministic: sums have a fixed order. All sizes are fixed at construction.
class Accelerator {
 public:
  virtual ~Accelerator() = default;

  virtual void begin_step() = 0;
  /// Writes the next x, and the next passenger, from the last evaluation of H. The outputs may be the same
  /// memory as the inputs. @return false when H(x) is not finite or the update is not: nothing is written
  /// then.
  [[nodiscard]] virtual bool next(const Iterate& at, std::span<double> x_next,
                                  std::span<double> passenger_next) = 0;
  bool next(const Iterate& at, std::span<double> x_next) { return next(at, x_next, {}); }
  /// Ends a step. Secants of a step that did not converge are true secants and stay; Aitken's factor does
  /// not.
  virtual void end_step(bool converged) = 0;
  /// Within a step: without all that was learnt, as at the very start.
  virtual void forget() = 0;
  /// Back to the state before the last begin_step.
  virtual void rollback() = 0;

  /// @pre between two steps
  [[nodiscard]] virtual State save() const = 0;
  /// Errors (ErrorKind::config): sizes that do not fit.
  [[nodiscard]] virtual Result<void> restore(const State& state) = 0;

  /// Columns that the last next() used (0: relaxation), and columns that its filter dropped.
  [[nodiscard]] virtual int used_columns() const { return 0; }
  [[nodiscard]] virtual int dropped_columns() const { return 0; }
};

/// @param n size of x  @param passenger size of the passenger, 0 without
/// @param weights {n} positive, or empty for ones: inner products are sum w_i a_i b_i, so that with the
/// lumped areas of
///        a surface the least squares and Aitken's products are those of L2.
/// Errors (ErrorKind::config): settings out of range, weights not positive.
[[nodiscard]] Result<std::unique_ptr<Accelerator>> make_accelerator(const Settings& settings, std::size_t n,
                                                                    std::size_t passenger = 0,
                                                                    std::span<const double> weights = {});

} // namespace drogue::acceleration
