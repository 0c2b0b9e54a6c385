// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstddef>
#include <cstdint>
#include <numeric>
#include <vector>

namespace drogue::meshing {

/// Union-find. The representative of a set is its smallest member, so that results do not depend on the order
/// of the unions.
class DisjointSets {
 public:
  explicit DisjointSets(std::size_t count) : parent_(count) { std::iota(parent_.begin(), parent_.end(), 0); }

  [[nodiscard]] std::int32_t find(std::int32_t a) {
    while (parent(a) != a) a = parent(a) = parent(parent(a));
    return a;
  }
  void unite(std::int32_t a, std::int32_t b) {
    a = find(a);
    b = find(b);
    if (a < b) parent(b) = a;
    if (b < a) parent(a) = b;
  }

 private:
  std::int32_t& parent(std::int32_t a) { return parent_[static_cast<std::size_t>(a)]; }
  std::vector<std::int32_t> parent_;
};

} // namespace drogue::meshing
