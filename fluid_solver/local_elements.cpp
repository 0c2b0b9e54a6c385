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
        entry.push_back(row.back() < 0 ? -1 : 2 * pattern.find(row.back(), pattern.local(own, b)));
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
  for (; count % (2 * batch_size) != 0; ++count) append(last, false);
  batches = count / batch_size;
  mark_first(pattern.column.size());
}

void LocalElements::mark_first(std::size_t positions) {
  const auto nodes = static_cast<std::size_t>(dimension) + 1;
  const std::size_t pairs = nodes * nodes;
  std::vector<char> reached(positions, 0);
  for (std::size_t batch = 0; batch < entry.size(); batch += 2 * batch_size * pairs)
    for (std::size_t pair = 0; pair < pairs; ++pair) // in the order in which blocks are added
      for (std::size_t l = 0; l < 2 * batch_size; ++l) {
        std::int32_t& place = entry[batch + pairs * l + pair];
        if (place < 0) continue;
        char& before = reached[static_cast<std::size_t>(place / 2)];
        if (before == 0) ++place;
        before = 1;
      }
}

} // namespace drogue::fluid
