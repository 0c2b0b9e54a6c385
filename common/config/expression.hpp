// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <memory>
#include <string>

#include "common/base/result.hpp"

namespace drogue::config {

/// A muParser expression of x, y, z, t (and the constant pi). Parsed once; evaluation does not allocate.
/// Copies are independent (each holds its own variables), so copies may be used from different threads.
class Expression {
 public:
  /// The constant zero.
  Expression();
  Expression(const Expression& other);
  Expression& operator=(const Expression& other);
  Expression(Expression&&) noexcept;
  Expression& operator=(Expression&&) noexcept;
  ~Expression();

  /// Errors (ErrorKind::config): text that does not parse or names an unknown variable; says where in the
  /// text.
  [[nodiscard]] static Result<Expression> parse(const std::string& text);

  [[nodiscard]] double operator()(double x, double y, double z, double t) const;
  [[nodiscard]] const std::string& text() const;
  /// The expression is literally a constant zero, so that callers may skip it.
  [[nodiscard]] bool is_zero() const;

 private:
  struct State;
  explicit Expression(const std::string& text);
  std::unique_ptr<State> state_;
};

/// Three expressions, one a component.
using VectorExpression = std::array<Expression, 3>;

} // namespace drogue::config
