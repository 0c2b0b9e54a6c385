// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <vector>

#include "common/la_direct/direct_solver.hpp"

namespace drogue::projection {

/// The elements around each node: those of node i are element[first[i]] to element[first[i + 1]], rising.
struct Adjacency {
  std::vector<std::int32_t> first;
  std::vector<std::int32_t> element;
  [[nodiscard]] std::span<const std::int32_t> around(std::int32_t node) const {
    const auto i = static_cast<std::size_t>(node);
    return {element.data() + first[i], static_cast<std::size_t>(first[i + 1] - first[i])};
  }
};

/// @param nodes_of element -> its nodes, a range of indices below `nodes`
template <class NodesOf>
[[nodiscard]] Adjacency elements_around(std::int32_t nodes, std::int32_t elements, const NodesOf& nodes_of) {
  Adjacency a;
  a.first.assign(static_cast<std::size_t>(nodes) + 1, 0);
  for (std::int32_t e = 0; e < elements; ++e)
    for (const std::int32_t i : nodes_of(e)) ++a.first[static_cast<std::size_t>(i) + 1];
  for (std::size_t i = 1; i < a.first.size(); ++i) a.first[i] += a.first[i - 1];
  a.element.resize(static_cast<std::size_t>(a.first.back()));
  std::vector<std::int32_t> next(a.first.begin(), a.first.end() - 1);
  for (std::int32_t e = 0; e < elements; ++e)
    for (const std::int32_t i : nodes_of(e))
      a.element[static_cast<std::size_t>(next[static_cast<std::size_t>(i)]++)] = e;
  return a;
}

/// One element's part of a sparse matrix: value(r, c) = factor values[r row_step + c column_step].
struct ElementPart {
  std::span<const std::int32_t> rows, columns;
  const double* values = nullptr;
  std::size_t row_step = 1, column_step = 1;
  double factor = 1;
};

/// Sum of element matrices, row by row, with sorted columns: no list of triplets. With `lower`, entries right
/// of the diagonal are left out; the arrays are then those of the upper triangle in compressed columns as
/// well.
/// @param part_of element -> ElementPart; @param around elements of each row
template <class PartOf>
[[nodiscard]] Eigen::SparseMatrix<double, Eigen::RowMajor, int>
sum_elements(std::int32_t rows, std::int32_t columns, const Adjacency& around, const PartOf& part_of,
             bool lower = false) {
  std::vector<int> place(static_cast<std::size_t>(columns), -1); // of a column in the present row
  std::vector<std::int32_t> found;
  const auto find_columns = [&](std::int32_t r) {
    found.clear();
    for (const std::int32_t e : around.around(r))
      for (const std::int32_t c : part_of(e).columns) {
        if ((lower && c > r) || place[static_cast<std::size_t>(c)] >= 0) continue;
        place[static_cast<std::size_t>(c)] = 0;
        found.push_back(c);
      }
  };
  const auto forget_columns = [&] {
    for (const std::int32_t c : found) place[static_cast<std::size_t>(c)] = -1;
  };
  // 1. Sizes.
  Eigen::SparseMatrix<double, Eigen::RowMajor, int> sum(rows, columns);
  int* first = sum.outerIndexPtr();
  for (std::int32_t r = 0; r < rows; ++r) {
    find_columns(r);
    first[r + 1] = first[r] + static_cast<int>(found.size());
    forget_columns();
  }
  sum.resizeNonZeros(first[rows]);
  // 2. Values.
  for (std::int32_t r = 0; r < rows; ++r) {
    find_columns(r);
    std::sort(found.begin(), found.end());
    int* column = sum.innerIndexPtr() + first[r];
    double* value = sum.valuePtr() + first[r];
    for (std::size_t k = 0; k < found.size(); ++k) {
      column[k] = found[k];
      value[k] = 0;
      place[static_cast<std::size_t>(found[k])] = static_cast<int>(k);
    }
    for (const std::int32_t e : around.around(r)) {
      const ElementPart part = part_of(e);
      for (std::size_t a = 0; a < part.rows.size(); ++a) {
        if (part.rows[a] != r) continue;
        for (std::size_t b = 0; b < part.columns.size(); ++b) {
          const std::int32_t c = part.columns[b];
          if (lower && c > r) continue;
          value[place[static_cast<std::size_t>(c)]] +=
              part.factor * part.values[a * part.row_step + b * part.column_step];
        }
      }
    }
    forget_columns();
  }
  return sum;
}

/// The lower triangle by rows, as the upper one by columns.
[[nodiscard]] inline la::SparseMatrix
upper_triangle(const Eigen::SparseMatrix<double, Eigen::RowMajor, int>& lower) {
  return Eigen::Map<const la::SparseMatrix>(lower.rows(), lower.cols(), lower.nonZeros(),
                                            lower.outerIndexPtr(), lower.innerIndexPtr(), lower.valuePtr());
}

} // namespace drogue::projection
