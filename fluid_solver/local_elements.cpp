// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>

#include "fluid_solver/batch.hpp"
#include "fluid_solver/element_loop.hpp"

namespace drogue::fluid {

LocalElements::LocalElements(const FluidMesh& mesh, const la::RowRange& own, const la::LocalPattern& pattern)
    : dimension(mesh.dimension) {
  const auto append = [&](std::span<const std::int32_t> nodes, bool active) {
    for (const std::int32_t a : nodes) {
      node.push_back(a);
      row.push_back(active && own.has(a) ? a - own.first : -1);
      for (const std::int32_t b : nodes)
        entry.push_back(row.back() < 0 ? -1 : pattern.find(row.back(), pattern.local(own, b)));
    }
  };
  std::span<const std::int32_t> last;
  int count = 0;
  for (std::int32_t e = 0; e < mesh.cell_count(); ++e) {
    const auto nodes = mesh.cell(e);
    if (std::none_of(nodes.begin(), nodes.end(), [&](std::int32_t i) { return own.has(i); })) continue;
    append(nodes, true);
    last = nodes;
    ++count;
  }
  for (; count % batch_size != 0; ++count) append(last, false);
  batches = count / batch_size;
}

} // namespace drogue::fluid
