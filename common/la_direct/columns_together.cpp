// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "common/base/isa.hpp"
#include "common/la_direct/column_kernels.hpp"

namespace drogue::la {

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

const ColumnKernels& column_kernels() {
  static const ColumnKernels* const of[] = {&baseline::column_kernels, &avx2::column_kernels,
                                            &avx512::column_kernels};
  return *of[static_cast<int>(best_isa())];
}

} // namespace drogue::la
