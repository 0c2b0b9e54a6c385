// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <set>

#include "common/meshing/repair.hpp"

namespace drogue::meshing {
namespace {

using Index = std::size_t;

Point& at(TetMesh& m, std::int32_t node) {
  return m.points[static_cast<Index>(node)];
}

bool contains(const Tet& tet, std::int32_t node) {
  return std::find(tet.begin(), tet.end(), node) != tet.end();
}

Tet replaced(Tet tet, std::int32_t old_node, std::int32_t new_node) {
  std::replace(tet.begin(), tet.end(), old_node, new_node);
  return tet;
}

/// The interior surface as nodes and edges.
struct Surface {
  explicit Surface(const TetMesh& m) : on_surface(m.points.size(), false) {
    for (const Triangle& t : m.interior)
      for (Index i = 0; i < 3; ++i) {
        on_surface[static_cast<Index>(t[i])] = true;
        edges.insert(sorted(Edge{t[i], t[(i + 1) % 3]}));
      }
  }
  [[nodiscard]] bool spans(const Tet& tet) const {
    return std::all_of(tet.begin(), tet.end(), [&](std::int32_t node) {
      return static_cast<Index>(node) < on_surface.size() && on_surface[static_cast<Index>(node)];
    });
  }
  std::vector<bool> on_surface;
  std::set<Edge> edges;
};

std::vector<std::int32_t> spanning_tets(const TetMesh& m, const Surface& surface) {
  std::vector<std::int32_t> found;
  for (Index e = 0; e < m.tets.size(); ++e)
    if (surface.spans(m.tets[e])) found.push_back(static_cast<std::int32_t>(e));
  return found;
}

struct Bridge {
  double square_length = 0;
  Edge edge{-1, -1};
};

/// The tet's longest edge that is not an edge of the surface; square length 0 when there is none.
Bridge longest_bridge(TetMesh& m, const Surface& surface, const Tet& tet) {
  Bridge best;
  for (Index i = 0; i < 4; ++i)
    for (Index j = 0; j < i; ++j) {
      const Edge edge = sorted(Edge{tet[i], tet[j]});
      const double l2 = (at(m, edge[0]) - at(m, edge[1])).squaredNorm();
      if (l2 > best.square_length && surface.edges.count(edge) == 0) best = {l2, edge};
    }
  return best;
}

std::int32_t add_node(TetMesh& m, const Point& x) {
  m.points.push_back(x);
  return static_cast<std::int32_t>(m.points.size()) - 1;
}

void split_edge(TetMesh& m, const Edge& edge, const std::vector<std::int32_t>& around) {
  const std::int32_t middle = add_node(m, 0.5 * (at(m, edge[0]) + at(m, edge[1])));
  for (const std::int32_t e : around) {
    const Tet tet = m.tets[static_cast<Index>(e)];
    m.tets[static_cast<Index>(e)] = replaced(tet, edge[0], middle);
    m.tets.push_back(replaced(tet, edge[1], middle));
  }
}

void split_tet(TetMesh& m, std::int32_t e) {
  const Tet tet = m.tets[static_cast<Index>(e)];
  const std::int32_t centre =
      add_node(m, 0.25 * (at(m, tet[0]) + at(m, tet[1]) + at(m, tet[2]) + at(m, tet[3])));
  m.tets[static_cast<Index>(e)] = replaced(tet, tet[0], centre);
  for (Index i = 1; i < 4; ++i) m.tets.push_back(replaced(tet, tet[i], centre));
}

/// Splits the bridges whose tets no other split of this round has touched.
void split_round(TetMesh& m, std::vector<Bridge> bridges, SplitSummary& summary) {
  std::sort(bridges.begin(), bridges.end(), [](const Bridge& a, const Bridge& b) {
    return a.square_length != b.square_length ? a.square_length > b.square_length : a.edge < b.edge;
  });
  const NodeTets node_tets(m.points.size(), m.tets);
  std::vector<bool> touched(m.tets.size(), false);
  for (const Bridge& bridge : bridges) {
    std::vector<std::int32_t> around;
    bool free = true;
    for (const std::int32_t e : node_tets.of(bridge.edge[0])) {
      if (touched[static_cast<Index>(e)]) {
        free = false; // the edge may be gone: next round
        break;
      }
      if (contains(m.tets[static_cast<Index>(e)], bridge.edge[1])) around.push_back(e);
    }
    if (!free) continue;
    for (const std::int32_t e : around) touched[static_cast<Index>(e)] = true;
    split_edge(m, bridge.edge, around);
    ++summary.edges_split;
  }
}

} // namespace

SplitSummary split_bridges(TetMesh& m) {
  SplitSummary summary;
  const Surface surface(m);
  std::vector<std::int32_t> spanning = spanning_tets(m, surface);
  summary.tets_before = static_cast<std::int32_t>(spanning.size());
  while (!spanning.empty()) { // every round splits at least the longest bridge or a tet
    std::vector<Bridge> bridges;
    for (const std::int32_t e : spanning) {
      const Bridge bridge = longest_bridge(m, surface, m.tets[static_cast<Index>(e)]);
      if (bridge.square_length > 0) {
        bridges.push_back(bridge);
      } else {
        split_tet(m, e);
        ++summary.tets_split;
      }
    }
    const auto same = [](const Bridge& a, const Bridge& b) { return a.edge == b.edge; };
    std::sort(bridges.begin(), bridges.end(),
              [](const Bridge& a, const Bridge& b) { return a.edge < b.edge; });
    bridges.erase(std::unique(bridges.begin(), bridges.end(), same), bridges.end());
    split_round(m, std::move(bridges), summary);
    spanning = spanning_tets(m, surface);
  }
  return summary;
}

} // namespace drogue::meshing
