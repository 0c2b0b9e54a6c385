// SPDX-License-Identifier: GPL-3.0-or-later
#include <gmsh.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <numeric>
#include <optional>
#include <set>

#include "common/mesh/gmsh_session.hpp"
#include "common/mesh/msh.hpp"

namespace drogue::mesh {
namespace {

using DimTag = std::pair<int, int>;

std::optional<ElementKind> kind_of(int gmsh_type) {
  switch (gmsh_type) {
  case 15:
    return ElementKind::point1;
  case 1:
    return ElementKind::line2;
  case 8:
    return ElementKind::line3;
  case 2:
    return ElementKind::tri3;
  case 9:
    return ElementKind::tri6;
  case 3:
    return ElementKind::quad4;
  case 10:
    return ElementKind::quad9;
  case 4:
    return ElementKind::tet4;
  case 11:
    return ElementKind::tet10;
  case 12:
    return ElementKind::hex27;
  default:
    return std::nullopt;
  }
}

std::string gmsh_name(int type) {
  std::string name;
  int dimension = 0, order = 0, nodes = 0, primary_nodes = 0;
  std::vector<double> parametric;
  gmsh::model::mesh::getElementProperties(type, name, dimension, order, nodes, parametric, primary_nodes);
  return name;
}

template <class T>
std::vector<std::size_t> order_by(const std::vector<T>& keys) {
  std::vector<std::size_t> order(keys.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(),
                   [&](std::size_t a, std::size_t b) { return keys[a] < keys[b]; });
  return order;
}

/// Index of a node in the mesh from its tag in the file.
class NodeNumbers {
 public:
  NodeNumbers() = default;
  /// @pre `sorted_tags` are ascending and unique
  explicit NodeNumbers(std::vector<std::size_t> sorted_tags)
      : tags_(std::move(sorted_tags)),
        contiguous_(tags_.empty() || tags_.back() - tags_.front() + 1 == tags_.size()) {}

  [[nodiscard]] std::optional<std::int32_t> index(std::size_t tag) const {
    if (tags_.empty() || tag < tags_.front() || tag > tags_.back()) return std::nullopt;
    if (contiguous_) return static_cast<std::int32_t>(tag - tags_.front());
    const auto found = std::lower_bound(tags_.begin(), tags_.end(), tag);
    if (*found != tag) return std::nullopt;
    return static_cast<std::int32_t>(found - tags_.begin());
  }
  [[nodiscard]] std::size_t tag(std::size_t index) const { return tags_[index]; }

 private:
  std::vector<std::size_t> tags_;
  bool contiguous_ = true;
};

/// Elements of one group and kind as Gmsh hands them out, entity by entity.
struct RawBlock {
  std::string group;
  ElementKind kind;
  std::vector<std::size_t> element_tags;
  std::vector<std::size_t> node_tags;
};

/// Steps of reading, on the model and the views of a session.
class Reader {
 public:
  Reader(const std::filesystem::path& file, const GmshSession& session)
      : file_(file.string()), session_(session) {}

  Result<Mesh> read() {
    gmsh::merge(file_);
    DROGUE_TRY(read_nodes());
    DROGUE_TRY(collect_blocks());
    DROGUE_TRY(check_all_grouped());
    DROGUE_TRY(convert_blocks());
    DROGUE_TRY(check_all_used());
    for (const int view : session_.new_views()) read_view(view);
    return std::move(mesh_);
  }

 private:
  Result<void> read_nodes() {
    std::vector<std::size_t> tags;
    std::vector<double> coordinates, parametric;
    gmsh::model::mesh::getNodes(tags, coordinates, parametric);
    if (tags.empty()) return config_error("{}: holds no mesh", file_);
    if (tags.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      return config_error("{}: {} nodes are more than a mesh can have", file_, tags.size());
    std::vector<std::size_t> sorted_tags;
    for (const std::size_t i : order_by(tags)) {
      if (!sorted_tags.empty() && sorted_tags.back() == tags[i])
        return config_error("{}: node {} appears twice", file_, tags[i]);
      sorted_tags.push_back(tags[i]);
      mesh_.points.insert(mesh_.points.end(), coordinates.begin() + static_cast<std::ptrdiff_t>(3 * i),
                          coordinates.begin() + static_cast<std::ptrdiff_t>(3 * i + 3));
    }
    numbers_ = NodeNumbers(std::move(sorted_tags));
    return {};
  }

  Result<void> collect_blocks() {
    std::vector<DimTag> groups;
    gmsh::model::getPhysicalGroups(groups);
    for (const auto& [dimension, tag] : groups) {
      std::string name;
      gmsh::model::getPhysicalName(dimension, tag, name);
      if (name.empty())
        return config_error(
            "{}: physical group {} of dimension {} has no name; name it in the mesh generator", file_, tag,
            dimension);
      std::vector<int> entities;
      gmsh::model::getEntitiesForPhysicalGroup(dimension, tag, entities);
      for (const int entity : entities) {
        grouped_.insert({dimension, entity});
        DROGUE_TRY(collect_entity(name, dimension, entity));
      }
    }
    if (raw_.empty())
      return config_error(
          "{}: no element belongs to a named physical group; define physical groups for the volume "
          "or surface and for every boundary in the mesh generator",
          file_);
    return {};
  }

  Result<void> collect_entity(const std::string& group, int dimension, int entity) {
    std::vector<int> types;
    std::vector<std::vector<std::size_t>> element_tags, node_tags;
    gmsh::model::mesh::getElements(types, element_tags, node_tags, dimension, entity);
    for (std::size_t i = 0; i < types.size(); ++i) {
      const auto kind = kind_of(types[i]);
      if (!kind)
        return config_error(
            "{}: group \"{}\" has elements of the unknown kind \"{}\"; known are points, lines of 2 "
            "or 3 nodes, triangles of 3 or 6, quadrangles of 4 or 9, tetrahedra of 4 or 10, hexahedra of 27",
            file_, group, gmsh_name(types[i]));
      RawBlock& block = raw_block(group, *kind);
      block.element_tags.insert(block.element_tags.end(), element_tags[i].begin(), element_tags[i].end());
      block.node_tags.insert(block.node_tags.end(), node_tags[i].begin(), node_tags[i].end());
    }
    return {};
  }

  RawBlock& raw_block(const std::string& group, ElementKind kind) {
    const auto found = std::find_if(raw_.begin(), raw_.end(),
                                    [&](const RawBlock& b) { return b.group == group && b.kind == kind; });
    return found != raw_.end() ? *found : raw_.emplace_back(RawBlock{group, kind, {}, {}});
  }

  Result<void> check_all_grouped() {
    std::vector<DimTag> entities;
    gmsh::model::getEntities(entities);
    for (const DimTag& entity : entities) {
      if (grouped_.count(entity) != 0) continue;
      std::vector<int> types;
      std::vector<std::vector<std::size_t>> element_tags, node_tags;
      gmsh::model::mesh::getElements(types, element_tags, node_tags, entity.first, entity.second);
      if (!types.empty())
        return config_error(
            "{}: {} elements of kind \"{}\" belong to no named physical group (geometric entity {} of "
            "dimension {})",
            file_, element_tags[0].size(), gmsh_name(types[0]), entity.second, entity.first);
    }
    return {};
  }

  /// Elements in the order of their tags, blocks in the order of their first element: the order of the file.
  Result<void> convert_blocks() {
    std::vector<std::size_t> first_tags;
    for (const RawBlock& raw : raw_)
      first_tags.push_back(*std::min_element(raw.element_tags.begin(), raw.element_tags.end()));
    for (const std::size_t b : order_by(first_tags)) DROGUE_TRY(convert(raw_[b]));
    return {};
  }

  Result<void> convert(const RawBlock& raw) {
    ElementBlock& block = mesh_.blocks.emplace_back(ElementBlock{raw.group, raw.kind, {}});
    block.nodes.reserve(raw.node_tags.size());
    const auto nodes = static_cast<std::size_t>(nodes_per_element(raw.kind));
    for (const std::size_t e : order_by(raw.element_tags))
      for (std::size_t a = 0; a < nodes; ++a) {
        const auto index = numbers_.index(raw.node_tags[e * nodes + a]);
        if (!index)
          return config_error("{}: element {} uses node {}, which is not there", file_, raw.element_tags[e],
                              raw.node_tags[e * nodes + a]);
        block.nodes.push_back(*index);
      }
    return {};
  }

  Result<void> check_all_used() const {
    std::vector<bool> used(static_cast<std::size_t>(mesh_.node_count()), false);
    for (const ElementBlock& block : mesh_.blocks)
      for (const std::int32_t node : block.nodes) used[static_cast<std::size_t>(node)] = true;
    const auto unused = std::count(used.begin(), used.end(), false);
    if (unused == 0) return {};
    const auto first = static_cast<std::size_t>(std::find(used.begin(), used.end(), false) - used.begin());
    return config_error("{}: {} nodes are used by no element (the first is node {}); remove them", file_,
                        unused, numbers_.tag(first));
  }

  void read_view(int view) {
    const std::string option = fmt::format("View[{}].", gmsh::view::getIndex(view));
    double steps = 1;
    gmsh::option::getNumber(option + "NbTimeStep", steps);
    std::string type, name;
    std::vector<std::size_t> tags;
    std::vector<double> values;
    double time = 0;
    NodeField field;
    gmsh::view::getHomogeneousModelData(view, static_cast<int>(steps) - 1, type, tags, values, time,
                                        field.components);
    if (type != "NodeData" || field.components < 1) return;
    gmsh::option::getString(option + "Name", name);
    const auto components = static_cast<std::size_t>(field.components);
    field.values.assign(mesh_.points.size() / 3 * components, std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < tags.size(); ++i)
      if (const auto node = numbers_.index(tags[i]))
        std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(i * components), components,
                    field.values.begin() + static_cast<std::ptrdiff_t>(*node) * field.components);
    mesh_.node_fields[name] = std::move(field);
  }

  std::string file_;
  const GmshSession& session_;
  Mesh mesh_;
  NodeNumbers numbers_;
  std::vector<RawBlock> raw_;
  std::set<DimTag> grouped_;
};

/// A file that does not begin as a mesh does Gmsh takes for a script, and runs it; a section without an end
/// it reads beyond the end.
Result<void> check_sections(const std::filesystem::path& file, std::istream& stream) {
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  if (text.rfind("$MeshFormat", 0) != 0)
    return config_error("{}: it does not begin with $MeshFormat: no mesh file", file.string());
  for (std::size_t at = 0; at != std::string::npos;) {
    const std::size_t name_end = text.find_first_of("\r\n \t", at);
    const std::string name = text.substr(at + 1, std::min(name_end, text.size()) - at - 1);
    const std::size_t end = text.find("\n$End" + name, at);
    if (name.empty() || end == std::string::npos)
      return config_error("{}: the section ${} has no $End{}", file.string(), name, name);
    const std::size_t next = text.find_first_not_of("\r\n \t", text.find('\n', end + 1));
    if (next != std::string::npos && text[next] != '$')
      return config_error("{}: after $End{} another section must begin", file.string(), name);
    at = next;
  }
  return {};
}

} // namespace

Result<Mesh> read_msh(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file))
    return config_error("{}: there is no such file", file.string());
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return config_error("{}: the file cannot be read", file.string());
  if (file.extension() == ".msh") DROGUE_TRY(check_sections(file, stream));
  const GmshSession session;
  try {
    return Reader(file, session).read();
  } catch (...) {
    return config_error("{}: Gmsh cannot read the file: {}", file.string(), gmsh_reason("no reason given"));
  }
}

} // namespace drogue::mesh
