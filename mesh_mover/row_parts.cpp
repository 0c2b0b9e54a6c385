// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/row_parts.hpp"

#include <algorithm>

#include "common/la_krylov/session.hpp"

namespace drogue::mesh_mover {
namespace {

/// Fewer rows than this a thread cost more in waking it up than they save.
constexpr std::size_t rows_per_thread = 5000;

int worthwhile(std::size_t rows) {
  return std::clamp(static_cast<int>(rows / rows_per_thread), 1,
                    std::max(1, default_threads() / la::rank_count()));
}

} // namespace

std::vector<RowRange> equal_parts(const SymmetricBlocks<double>& A, RowRange whole, int parts) {
  const std::size_t first = A.begin(whole.first), blocks = A.begin(whole.last) - first;
  const auto n = static_cast<std::size_t>(parts);
  std::vector<RowRange> result;
  std::size_t start = whole.first;
  for (std::size_t part = 1; part < n; ++part) {
    const auto wanted = static_cast<std::int32_t>(first + blocks * part / n);
    const auto row = std::lower_bound(A.row_start.begin(), A.row_start.end(), wanted) - A.row_start.begin();
    result.push_back({start, std::max(start, static_cast<std::size_t>(row))});
    start = result.back().last;
  }
  result.push_back({start, whole.last});
  return result;
}

RowParts::RowParts(const SymmetricBlocks<double>& A, RowRange own, int parts)
    : pool_(parts > 0 ? parts : worthwhile(own.last - own.first)), parts_(equal_parts(A, own, count())) {}

int RowParts::part_of(std::size_t row) const noexcept {
  const auto ends_before = [](std::size_t i, const RowRange& part) { return i < part.last; };
  return static_cast<int>(std::upper_bound(parts_.begin(), parts_.end() - 1, row, ends_before) -
                          parts_.begin());
}

PartedProduct::PartedProduct(const SymmetricBlocks<double>& A, const RowParts& parts) : A_(A), parts_(parts) {
  for (int part = 0; part < parts.count(); ++part) {
    std::size_t low = parts.begin(part);
    for (std::size_t i = parts.begin(part); i < parts.end(part); ++i) // columns ascend in a row
      low = std::min(low, static_cast<std::size_t>(A.column[A.begin(i)]));
    low_.push_back(low);
    earlier_.emplace_back(3 * (parts.begin(part) - low));
  }
  for (std::size_t i = parts.own().last; i < A.rows(); ++i)
    for (std::size_t k = A.begin(i); k < A.diagonal(i); ++k)
      if (const auto j = static_cast<std::size_t>(A.column[k]); parts.own().has(j))
        below_.push_back({k, i, j});
}

void PartedProduct::multiply_part(int part, std::span<const double> x, std::span<double> y) noexcept {
  const std::size_t first = parts_.begin(part);
  auto& earlier = earlier_[static_cast<std::size_t>(part)];
  std::fill(earlier.begin(), earlier.end(), 0.0);
  const std::size_t low = low_[static_cast<std::size_t>(part)];
  for (std::size_t i = first; i < parts_.end(part); ++i) {
    const std::size_t diagonal = A_.diagonal(i);
    const double x0 = x[3 * i], x1 = x[3 * i + 1], x2 = x[3 * i + 2];
    const double* K = &A_.values[9 * diagonal]; // column-major
    double y0 = K[0] * x0 + K[3] * x1 + K[6] * x2;
    double y1 = K[1] * x0 + K[4] * x1 + K[7] * x2;
    double y2 = K[2] * x0 + K[5] * x1 + K[8] * x2;
    for (std::size_t k = A_.begin(i); k < diagonal; ++k) {
      const auto j = static_cast<std::size_t>(A_.column[k]);
      K = &A_.values[9 * k];
      const double* x_j = &x[3 * j];
      y0 += K[0] * x_j[0] + K[3] * x_j[1] + K[6] * x_j[2];
      y1 += K[1] * x_j[0] + K[4] * x_j[1] + K[7] * x_j[2];
      y2 += K[2] * x_j[0] + K[5] * x_j[1] + K[8] * x_j[2];
      double* y_j = j < first ? earlier.data() + 3 * (j - low) : y.data() + 3 * j;
      y_j[0] += K[0] * x0 + K[1] * x1 + K[2] * x2;
      y_j[1] += K[3] * x0 + K[4] * x1 + K[5] * x2;
      y_j[2] += K[6] * x0 + K[7] * x1 + K[8] * x2;
    }
    y[3 * i] = y0; // later rows add to them
    y[3 * i + 1] = y1;
    y[3 * i + 2] = y2;
  }
}

void PartedProduct::multiply(std::span<const double> x, std::span<double> y) {
  parts_.run([&](int part) { multiply_part(part, x, y); });
  const std::size_t first = parts_.own().first;
  for (std::size_t part = 0; part < earlier_.size(); ++part)
    for (std::size_t k = 3 * (std::max(low_[part], first) - low_[part]); k < earlier_[part].size(); ++k)
      y[3 * low_[part] + k] += earlier_[part][k];
  for (const Below& b : below_)
    Eigen::Map<Eigen::Vector3d>(&y[3 * b.column]) +=
        A_.block(b.block).transpose() * Eigen::Map<const Eigen::Vector3d>(&x[3 * b.row]);
}

} // namespace drogue::mesh_mover
