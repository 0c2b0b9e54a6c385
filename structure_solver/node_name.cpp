// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/node_name.hpp"

#include <algorithm>
#include <vector>

#include <fmt/format.h>

namespace drogue::structure {

std::string node_name(const mesh::Mesh& mesh, std::int32_t node) {
  std::vector<std::string> groups;
  for (const mesh::ElementBlock& block : mesh.blocks) {
    const bool member = std::find(block.nodes.begin(), block.nodes.end(), node) != block.nodes.end();
    const std::string name = fmt::format("\"{}\"", block.group);
    if (member && std::find(groups.begin(), groups.end(), name) == groups.end()) groups.push_back(name);
  }
  const double* X = &mesh.points[3 * static_cast<std::size_t>(node)];
  return fmt::format("node {} at ({:.6g}, {:.6g}, {:.6g}) of {}", node, X[0], X[1], X[2],
                     groups.empty() ? "no group" : fmt::format("{}", fmt::join(groups, ", ")));
}

} // namespace drogue::structure
