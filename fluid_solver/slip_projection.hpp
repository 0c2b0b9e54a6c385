// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <span>
#include <vector>

#include "common/la_krylov/block_matrix.hpp"
#include "fluid_solver/slip_walls.hpp"
#include "fluid_solver/step_data.hpp"

namespace drogue::fluid {

/// Takes the velocities that free slip holds out of the linear system, without rotating any unknown:
///   J := P J P + s Q,   r := P r,   dw := P dw,   Q = sum n n^T over the held directions, P = I - Q,
/// node by node and time level by time level. s, the size of the node's own velocity entries, keeps the
/// single-precision pivots well scaled. P depends smoothly on the normals, so that a lagged Jacobian stays
/// good on a mesh that moves on.
template <int n>
class SlipProjection {
 public:
  static constexpr std::size_t levels = n / 4;

  SlipProjection(std::span<const std::int32_t> nodes, const la::RowRange& own,
                 const la::LocalPattern& pattern)
      : slip_of_(static_cast<std::size_t>(pattern.columns()), -1) {
    for (std::size_t k = 0; k < nodes.size(); ++k)
      if (const std::int32_t local = pattern.local(own, nodes[k]); local >= 0)
        slip_of_[static_cast<std::size_t>(local)] = static_cast<std::int32_t>(k);
  }

  /// Takes over the directions of this state.
  void set(const StepData& data) {
    directions_[levels - 1] = data.slip_np1;
    if (levels == 2) directions_[0] = data.slip_n;
  }

  /// Projects the velocities of own rows {rows, n}.
  void apply(std::span<double> values) const noexcept {
    for (std::size_t i = 0; i < values.size() / n; ++i)
      for (std::size_t q = 0; q < levels && slip_of_[i] >= 0; ++q)
        at(i, q).project(values.data() + n * i + 4 * q);
  }

  void apply(la::BlockMatrix<n>& matrix) const noexcept {
    const la::LocalPattern& pattern = matrix.pattern();
    for (std::size_t i = 0; i < static_cast<std::size_t>(pattern.rows); ++i)
      for (std::int32_t k = pattern.row_start[i]; k < pattern.row_start[i + 1]; ++k) {
        const auto j = static_cast<std::size_t>(pattern.column[static_cast<std::size_t>(k)]);
        float* block = matrix.block(k);
        const std::array<double, levels> size = i == j ? diagonal_size(block) : std::array<double, levels>{};
        for (std::size_t q = 0; q < levels; ++q) {
          if (slip_of_[i] >= 0) project_all(at(i, q), block + 4 * q, 1, n);
          if (slip_of_[j] >= 0) project_all(at(j, q), block + 4 * q * n, n, 1);
          if (i == j && slip_of_[i] >= 0) add_held(at(i, q), size[q], block + (n + 1) * 4 * q);
        }
      }
  }

 private:
  [[nodiscard]] const SlipDirections& at(std::size_t column, std::size_t level) const noexcept {
    return directions_[level][static_cast<std::size_t>(slip_of_[column])];
  }

  /// Projects n vectors of three entries `stride` apart, the vectors `step` apart.
  static void project_all(const SlipDirections& directions, float* values, std::size_t stride,
                          std::size_t step) noexcept {
    for (std::size_t m = 0; m < n; ++m, values += step) {
      double v[3];
      for (std::size_t d = 0; d < 3; ++d) v[d] = static_cast<double>(values[d * stride]);
      directions.project(v);
      for (std::size_t d = 0; d < 3; ++d) values[d * stride] = static_cast<float>(v[d]);
    }
  }

  static std::array<double, levels> diagonal_size(const float* block) noexcept {
    std::array<double, levels> size{};
    for (std::size_t q = 0; q < levels; ++q) {
      for (std::size_t d = 4 * q; d < 4 * q + 3; ++d)
        size[q] += std::fabs(static_cast<double>(block[(n + 1) * d])) / 3;
      if (!(size[q] > 0)) size[q] = 1;
    }
    return size;
  }

  static void add_held(const SlipDirections& directions, double size, float* block) noexcept {
    for (int k = 0; k < directions.count; ++k)
      for (int j = 0; j < 3; ++j)
        for (int i = 0; i < 3; ++i)
          block[n * j + i] += static_cast<float>(size * directions.n[k][i] * directions.n[k][j]);
  }

  std::vector<std::int32_t> slip_of_; ///< of each local column: index into the directions, or -1
  std::array<std::vector<SlipDirections>, levels> directions_;
};

} // namespace drogue::fluid
