// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/project/surface_file.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/ranges.h>

#include "common/mesh/msh.hpp"

namespace drogue::coupler {
namespace {

std::vector<std::string> surface_groups(const mesh::Mesh& mesh) {
  std::vector<std::string> groups;
  for (const std::string& name : mesh.group_names()) {
    const auto blocks = mesh.blocks_of(name);
    if (std::all_of(blocks.begin(), blocks.end(),
                    [](const auto* b) { return mesh::dimension(b->kind) == 2; }))
      groups.push_back(name);
  }
  return groups;
}

Result<std::string> choose_group(const std::filesystem::path& file, const std::string& group,
                                 const std::vector<std::string>& groups) {
  if (groups.empty()) return config_error("{}: no group of surface elements", file.string());
  if (group.empty() && groups.size() > 1)
    return config_error("{}: holds several surfaces; name one of them: {}", file.string(),
                        fmt::join(groups, ", "));
  if (!group.empty() && std::find(groups.begin(), groups.end(), group) == groups.end())
    return config_error("{}: no surface named \"{}\" (there are: {})", file.string(), group,
                        fmt::join(groups, ", "));
  return group.empty() ? groups.front() : group;
}

std::vector<double> rows(const std::vector<double>& values, const std::vector<std::int32_t>& nodes) {
  std::vector<double> chosen;
  chosen.reserve(3 * nodes.size());
  for (const std::int32_t node : nodes)
    chosen.insert(chosen.end(), values.begin() + 3 * std::ptrdiff_t{node},
                  values.begin() + 3 * std::ptrdiff_t{node} + 3);
  return chosen;
}

} // namespace

Result<SurfaceFile> read_surface(const std::filesystem::path& file, const std::string& group) {
  auto mesh = mesh::read_msh(file);
  if (!mesh) return mesh.error();
  auto chosen = choose_group(file, group, surface_groups(*mesh));
  if (!chosen) return chosen.error();
  SurfaceFile read{std::move(*mesh), *chosen, {}, {}};
  read.nodes = read.mesh.nodes_of(read.group);
  projection::Surface& s = read.surface;
  s.name = fmt::format("\"{}\" ({})", read.group, file.filename().string());
  s.points = rows(read.mesh.points, read.nodes);
  const auto material = read.mesh.node_fields.find("material");
  if (material != read.mesh.node_fields.end() && material->second.components == 3) {
    s.material = rows(material->second.values, read.nodes);
    const bool complete =
        std::all_of(s.material.begin(), s.material.end(), [](double v) { return std::isfinite(v); });
    if (!complete) s.material.clear();
  }
  std::vector<std::int32_t> number(read.mesh.points.size() / 3, -1);
  for (std::size_t i = 0; i < read.nodes.size(); ++i)
    number[static_cast<std::size_t>(read.nodes[i])] = static_cast<std::int32_t>(i);
  for (const mesh::ElementBlock* block : read.mesh.blocks_of(read.group)) {
    s.blocks.push_back(*block);
    for (std::int32_t& node : s.blocks.back().nodes) node = number[static_cast<std::size_t>(node)];
  }
  DROGUE_TRY(projection::complete(s));
  return read;
}

} // namespace drogue::coupler
