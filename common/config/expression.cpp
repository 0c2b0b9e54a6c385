// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/config/expression.hpp"

#include <cstdlib>
#include <numbers>

#include <muParser.h>

namespace drogue::config {

struct Expression::State {
  std::string text;
  bool zero = false;
  // muParser keeps pointers to these: a State never moves.
  mutable double x = 0, y = 0, z = 0, t = 0;
  mu::Parser parser;
};

Expression::Expression() : Expression("0") {}

Expression::Expression(const std::string& text) : state_(std::make_unique<State>()) {
  State& s = *state_;
  s.text = text;
  s.parser.DefineVar("x", &s.x);
  s.parser.DefineVar("y", &s.y);
  s.parser.DefineVar("z", &s.z);
  s.parser.DefineVar("t", &s.t);
  s.parser.DefineConst("pi", std::numbers::pi);
  s.parser.SetExpr(text);
  char* end = nullptr;
  s.zero = std::strtod(text.c_str(), &end) == 0 && end == text.c_str() + text.size() && !text.empty();
}

Expression::Expression(const Expression& other) : Expression(other.state_->text) {}
Expression& Expression::operator=(const Expression& other) {
  if (this != &other) *this = Expression(other);
  return *this;
}
Expression::Expression(Expression&&) noexcept = default;
Expression& Expression::operator=(Expression&&) noexcept = default;
Expression::~Expression() = default;

Result<Expression> Expression::parse(const std::string& text) {
  try {
    Expression expression(text);
    (void)expression.state_->parser.Eval();
    return expression;
  } catch (const mu::Parser::exception_type& e) {
    return config_error("the expression \"{}\" does not parse: {}", text, e.GetMsg());
  }
}

double Expression::operator()(double x, double y, double z, double t) const {
  const State& s = *state_;
  s.x = x;
  s.y = y;
  s.z = z;
  s.t = t;
  return s.parser.Eval();
}

const std::string& Expression::text() const {
  return state_->text;
}
bool Expression::is_zero() const {
  return state_->zero;
}

} // namespace drogue::config
