// SPDX-License-Identifier: GPL-3.0-or-later
#include "fluid_solver/batch.hpp"
#include "fluid_solver/element_loop.hpp"

namespace drogue::fluid {

LocalElements::LocalElements(const FluidMesh& mesh, const la::RowRange& own,
                             const la::LocalPattern& pattern) {
  const auto append = [&](const std::int32_t* t, bool active) {
    for (int a = 0; a < 4; ++a) {
      node.push_back(t[a]);
      row.push_back(active && own.has(t[a]) ? t[a] - own.first : -1);
      for (int b = 0; b < 4; ++b)
        entry.push_back(row.back() < 0 ? -1 : pattern.find(row.back(), pattern.local(own, t[b])));
    }
  };
  const std::int32_t* last = nullptr;
  int count = 0;
  for (std::size_t e = 0; e < mesh.tets.size(); e += 4) {
    const std::int32_t* t = mesh.tets.data() + e;
    if (!own.has(t[0]) && !own.has(t[1]) && !own.has(t[2]) && !own.has(t[3])) continue;
    append(t, true);
    last = t;
    ++count;
  }
  for (; count % batch_size != 0; ++count) append(last, false);
  batches = count / batch_size;
}

} // namespace drogue::fluid
