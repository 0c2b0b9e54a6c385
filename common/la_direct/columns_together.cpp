// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "common/base/isa.hpp"
#include "common/la_direct/column_kernels.hpp"

namespace drogue::la {

namespace {

/// Where the groups start, and the end of the last.
std::vector<std::int32_t> columns_together(const FactorColumns& f) {
  std::vector<std::int32_t> start;
  const auto goes_on = [&](std::int32_t k) { // the rows below the diagonal are those of the next column
    const std::int32_t* below = f.row + f.first[k] + 1;
    return f.count[k] == f.count[k + 1] + 1 &&
           std::equal(below, below + f.count[k] - 1, f.row + f.first[k + 1]);
  };
  for (std::int32_t k = 0; k < f.n;) {
    start.push_back(k);
    const std::int32_t end = k + most_columns_together;
    do ++k;
    while (k < end && k < f.n && goes_on(k - 1));
  }
  start.push_back(f.n);
  return start;
}

} // namespace

GroupedFactor grouped(const FactorColumns& f) {
  GroupedFactor made;
  made.group = columns_together(f);
  std::size_t entries = 0, rows_of_all = 0;
  for (std::int32_t k = 0; k < f.n; ++k) entries += static_cast<std::size_t>(f.count[k]);
  for (std::size_t g = 1; g < made.group.size(); ++g)
    rows_of_all += static_cast<std::size_t>(f.count[made.group[g] - 1] - 1);
  made.value.reserve(entries);
  made.row.reserve(rows_of_all);
  for (std::size_t g = 0; g + 1 < made.group.size(); ++g) {
    const std::int32_t start = made.group[g], end = made.group[g + 1], last = end - 1;
    for (std::int32_t k = start; k < end; ++k) {
      const double* column = f.L + f.first[k];
      made.value.push_back(1 / column[0]);
      made.value.insert(made.value.end(), column + 1, column + (end - k));
    }
    const std::int32_t rows = f.count[last] - 1;
    const std::int32_t* row = f.row + f.first[last] + 1;
    made.row.insert(made.row.end(), row, row + rows);
    made.first_row.push_back(static_cast<std::int32_t>(made.row.size()));
    for (std::int32_t r = 0; r < rows; ++r)
      for (std::int32_t k = start; k < end; ++k) made.value.push_back(f.L[f.first[k] + (end - k) + r]);
  }
  return made;
}

const ColumnKernels& column_kernels() {
  static const ColumnKernels* const of[] = {&baseline::column_kernels, &avx2::column_kernels,
                                            &avx512::column_kernels};
  return *of[static_cast<int>(best_isa())];
}

} // namespace drogue::la
