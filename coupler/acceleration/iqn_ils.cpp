// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/acceleration/iqn_ils.hpp"

#include <algorithm>
#include <cmath>

#include "coupler/acceleration/relaxation.hpp"
#include "coupler/acceleration/vector_ops.hpp"

namespace drogue::acceleration {
namespace {

constexpr double smallest_squared_ratio = 1e-13;
constexpr std::size_t rows_at_once = 512;

/// Calls visit(start, size) for every block of the n rows.
template <class Visit>
void for_blocks(std::size_t n, Visit&& visit) {
  for (std::size_t start = 0; start < n; start += rows_at_once)
    visit(start, std::min(rows_at_once, n - start));
}

std::span<const double> rows(const std::vector<double>& v, std::size_t start, std::size_t size) {
  return std::span(v).subspan(start, size);
}

/// y += sum_j c_j times the member `what` of the columns kept.
template <class Columns, class Values>
void add_columns(const std::vector<double>& c, const Columns& columns, const std::vector<std::size_t>& kept,
                 Values what, std::span<double> y) {
  for_blocks(y.size(), [&](std::size_t start, std::size_t size) {
    for (std::size_t j = 0; j < c.size(); ++j)
      add_scaled(c[j], rows((*columns[kept[j]]).*what, start, size), y.subspan(start, size));
  });
}

/// The products of v with all columns: with `dr`, which is the newest, and the given ones with those before.
std::vector<double> with_own(const std::vector<double>& dr, const std::vector<double>& v,
                             std::vector<double> products) {
  products.insert(products.begin(), dot(dr, v));
  return products;
}

std::size_t packed(std::size_t i, std::size_t j) {
  return j * (j + 1) / 2 + i;
}

} // namespace

IqnIls::IqnIls(const Settings& settings, std::span<const double> weights, std::size_t n,
               std::size_t passenger)
    : settings_(settings),
      root_weights_(n, 1.0),
      passenger_(passenger),
      r_(n),
      r_last_(n),
      h_last_(n),
      p_last_(passenger) {
  for (std::size_t i = 0; i < weights.size(); ++i) root_weights_[i] = std::sqrt(weights[i]);
}

void IqnIls::begin_step() {
  columns_at_begin_ = columns_;
  step_at_begin_ = step_;
  ++step_;
  while (!columns_.empty() && columns_.back()->step < step_ - settings_.reuse_steps) columns_.pop_back();
  has_last_ = false;
}

void IqnIls::end_step(bool) {
  has_last_ = false;
}

void IqnIls::forget() {
  columns_.clear();
  has_last_ = false;
}

void IqnIls::rollback() {
  columns_ = columns_at_begin_;
  step_ = step_at_begin_;
  has_last_ = false;
}

/// Of each vector with the dr of each column, newest first; block by block, so that the columns are read
/// once.
std::vector<std::vector<double>>
IqnIls::products(std::initializer_list<std::span<const double>> vectors) const {
  std::vector<std::vector<double>> sums(vectors.size(), std::vector<double>(columns_.size(), 0.0));
  for_blocks(r_.size(), [&](std::size_t start, std::size_t size) {
    for (std::size_t k = 0; k < columns_.size(); ++k) {
      auto sum = sums.begin();
      for (const auto vector : vectors)
        (*sum++)[k] += dot(vector.subspan(start, size), rows(columns_[k]->dr, start, size));
    }
  });
  return sums;
}

/// The secant from the last iterate to `at`, and the products that it and r need.
void IqnIls::add_column(const Iterate& at) {
  const auto change = [](std::span<const double> to, const std::vector<double>& from) {
    std::vector<double> d(to.begin(), to.end());
    add_scaled(-1, std::span(from), std::span(d));
    return d;
  };
  std::vector<double> dr = change(r_, r_last_);
  auto sums = products({dr, r_});
  of_r_ = with_own(dr, r_, std::move(sums[1]));
  std::vector<double> gram = with_own(dr, dr, std::move(sums[0]));
  columns_.push_front(std::make_shared<const Column>(
      Column{step_, std::move(dr), change(at.h, h_last_), change(at.h_passenger, p_last_), std::move(gram)}));
}

/// Cholesky of the Gram matrix of the columns begin to end, newest first, leaving out what fails the filter.
void IqnIls::factor(std::size_t begin, std::size_t end) {
  kept_.clear();
  R_.clear();
  const double threshold = std::max(settings_.filter * settings_.filter, smallest_squared_ratio);
  for (std::size_t k = begin; k < end && kept_.size() < r_.size(); ++k) {
    const std::size_t m = kept_.size();
    double square = columns_[k]->gram[0];
    const double whole = square;
    R_.resize(packed(0, m) + m + 1);
    for (std::size_t i = 0; i < m; ++i) {
      double value = columns_[kept_[i]]->gram[k - kept_[i]];
      for (std::size_t l = 0; l < i; ++l) value -= R_[packed(l, i)] * R_[packed(l, m)];
      value /= R_[packed(i, i)];
      R_[packed(i, m)] = value;
      square -= value * value;
    }
    if (!(whole > 0) || !(square > threshold * whole)) {
      R_.resize(packed(0, m));
      ++dropped_;
      continue;
    }
    R_[packed(m, m)] = std::sqrt(square);
    kept_.push_back(k);
  }
}

/// The c with R^T R c = b, in place.
void IqnIls::solve_normal_equations(std::vector<double>& b) const {
  const std::size_t m = kept_.size();
  for (std::size_t j = 0; j < m; ++j) {
    for (std::size_t i = 0; i < j; ++i) b[j] -= R_[packed(i, j)] * b[i];
    b[j] /= R_[packed(j, j)];
  }
  for (std::size_t j = m; j-- > 0;) {
    b[j] /= R_[packed(j, j)];
    for (std::size_t i = 0; i < j; ++i) b[i] -= R_[packed(i, j)] * b[j];
  }
}

/// arg min | rest + sum_j c_j dr_j | over the columns kept of the group that starts with column `begin`, once
/// more on what the first solution leaves. That is formed and multiplied with the columns block by block,
/// while these are near.
std::vector<double> IqnIls::least_squares(std::size_t begin) const {
  const std::size_t m = kept_.size(), n = rest_.size();
  std::vector<double> c(m), more(m, 0.0), rest(rows_at_once);
  for (std::size_t j = 0; j < m; ++j)
    c[j] = -(begin == 0 ? of_r_[kept_[j]] : dot(columns_[kept_[j]]->dr, rest_));
  solve_normal_equations(c);
  for_blocks(n, [&](std::size_t start, std::size_t size) {
    const std::span<double> part(rest.data(), size);
    std::copy_n(rest_.data() + start, size, part.data());
    for (std::size_t j = 0; j < m; ++j) add_scaled(c[j], rows(columns_[kept_[j]]->dr, start, size), part);
    for (std::size_t j = 0; j < m; ++j) more[j] -= dot(rows(columns_[kept_[j]]->dr, start, size), part);
  });
  solve_normal_equations(more);
  for (std::size_t j = 0; j < m; ++j) c[j] += more[j];
  return c;
}

/// IQN-ILS: all columns; IQN-IMVJ: those of the step of column `begin`.
std::size_t IqnIls::end_of_group(std::size_t begin) const {
  if (settings_.method == Method::iqn_ils) return columns_.size();
  std::size_t end = begin;
  while (end < columns_.size() && columns_[end]->step == columns_[begin]->step) ++end;
  return end;
}

/// Takes from the rest what the columns of a group can, and adds their part of the update.
bool IqnIls::add_group(std::size_t begin, std::size_t end, std::span<double> x_next,
                       std::span<double> passenger_next) {
  factor(begin, end);
  used_ += static_cast<int>(kept_.size());
  const std::vector<double> c = least_squares(begin);
  if (!all_finite(c)) return false;
  if (end < columns_.size()) add_columns(c, columns_, kept_, &Column::dr, rest_);
  add_columns(c, columns_, kept_, &Column::dh, x_next);
  add_columns(c, columns_, kept_, &Column::dp, passenger_next);
  return true;
}

bool IqnIls::next(const Iterate& at, std::span<double> x_next, std::span<double> passenger_next) {
  if (!all_finite(at.h) || !all_finite(at.h_passenger)) return false;
  // 1. The scaled residual, and the secant to the last one.
  for (std::size_t i = 0; i < r_.size(); ++i) r_[i] = root_weights_[i] * (at.h[i] - at.x[i]);
  if (has_last_) {
    add_column(at);
  } else {
    of_r_ = std::move(products({r_})[0]);
  }
  while (columns_.size() > static_cast<std::size_t>(settings_.max_columns)) columns_.pop_back();
  r_last_ = r_;
  std::copy(at.h.begin(), at.h.end(), h_last_.begin());
  std::copy(at.h_passenger.begin(), at.h_passenger.end(), p_last_.begin());
  has_last_ = true;
  // 2. The groups of columns, each on what the newer ones leave of r.
  used_ = dropped_ = 0;
  rest_ = r_;
  std::vector<double> x(h_last_), passenger(p_last_);
  for (std::size_t begin = 0; begin < columns_.size(); begin = end_of_group(begin))
    if (!add_group(begin, end_of_group(begin), x, passenger)) return false;
  // 3. The update.
  if (used_ == 0) {
    relax(settings_.relaxation, at.x, at.h, x_next);
    relax(settings_.relaxation, at.x_passenger, at.h_passenger, passenger_next);
    return true;
  }
  std::copy(x.begin(), x.end(), x_next.begin());
  std::copy(passenger.begin(), passenger.end(), passenger_next.begin());
  return true;
}

State IqnIls::save() const {
  State state;
  state.step = step_;
  for (const auto& column : columns_) {
    state.column_step.push_back(column->step);
    state.column_dr.insert(state.column_dr.end(), column->dr.begin(), column->dr.end());
    state.column_dh.insert(state.column_dh.end(), column->dh.begin(), column->dh.end());
    state.column_dp.insert(state.column_dp.end(), column->dp.begin(), column->dp.end());
  }
  return state;
}

Result<void> IqnIls::restore(const State& state) {
  const std::size_t m = state.column_step.size(), n = r_.size();
  if (state.column_dr.size() != m * n || state.column_dh.size() != m * n ||
      state.column_dp.size() != m * passenger_)
    return config_error(
        "accelerator state: {} columns of sizes {} + {} + {} do not fit {} + {} + {} values a column", m,
        state.column_dr.size(), state.column_dh.size(), state.column_dp.size(), n, n, passenger_);
  columns_.clear();
  for (std::size_t k = m; k-- > 0;) {
    const auto part = [k](const std::vector<double>& all, std::size_t size) {
      const auto first = all.begin() + static_cast<std::ptrdiff_t>(k * size);
      return std::vector<double>(first, first + static_cast<std::ptrdiff_t>(size));
    };
    Column column{state.column_step[k],
                  part(state.column_dr, n),
                  part(state.column_dh, n),
                  part(state.column_dp, passenger_),
                  {}};
    column.gram = with_own(column.dr, column.dr, std::move(products({column.dr})[0]));
    columns_.push_front(std::make_shared<const Column>(std::move(column)));
  }
  step_ = state.step;
  has_last_ = false;
  return {};
}

} // namespace drogue::acceleration
