// SPDX-License-Identifier: GPL-3.0-or-later
#include <algorithm>
#include <fstream>
#include <iterator>
#include <limits>
#include <numeric>
#include <optional>
#include <tuple>

#include "common/mesh/msh.hpp"
#include "common/mesh/msh_content.hpp"

namespace drogue::mesh {
namespace {

using Tags = std::vector<std::uint64_t>;

std::vector<std::size_t> order_by(const Tags& keys) {
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
  explicit NodeNumbers(Tags sorted_tags)
      : tags_(std::move(sorted_tags)),
        contiguous_(tags_.empty() || tags_.back() - tags_.front() + 1 == tags_.size()) {}

  [[nodiscard]] std::optional<std::int32_t> index(std::uint64_t tag) const {
    if (tags_.empty() || tag < tags_.front() || tag > tags_.back()) return std::nullopt;
    if (contiguous_) return static_cast<std::int32_t>(tag - tags_.front());
    const auto found = std::lower_bound(tags_.begin(), tags_.end(), tag);
    if (*found != tag) return std::nullopt;
    return static_cast<std::int32_t>(found - tags_.begin());
  }
  [[nodiscard]] std::uint64_t tag(std::size_t index) const { return tags_[index]; }

 private:
  Tags tags_;
  bool contiguous_ = true;
};

/// Elements of one named group and kind, entity by entity.
struct RawBlock {
  std::string group;
  ElementKind kind;
  Tags element_tags;
  Tags node_tags;
};

/// Makes a mesh of what a file holds.
class Reader {
 public:
  Reader(std::string file, MshContent content) : file_(std::move(file)), content_(std::move(content)) {}

  Result<Mesh> read() {
    DROGUE_TRY(read_nodes());
    DROGUE_TRY(collect_blocks());
    DROGUE_TRY(convert_blocks());
    DROGUE_TRY(check_all_used());
    for (const auto& [name, field] : content_.fields) DROGUE_TRY(read_field(name, field));
    return std::move(mesh_);
  }

 private:
  Result<void> read_nodes() {
    const Tags& tags = content_.node_tags;
    if (tags.empty()) return config_error("{}: holds no mesh", file_);
    if (tags.size() > static_cast<std::size_t>(std::numeric_limits<std::int32_t>::max()))
      return config_error("{}: {} nodes are more than a mesh can have", file_, tags.size());
    Tags sorted_tags;
    for (const std::size_t i : order_by(tags)) {
      if (!sorted_tags.empty() && sorted_tags.back() == tags[i])
        return config_error("{}: node {} appears twice", file_, tags[i]);
      sorted_tags.push_back(tags[i]);
      const auto point = content_.points.begin() + static_cast<std::ptrdiff_t>(3 * i);
      mesh_.points.insert(mesh_.points.end(), point, point + 3);
    }
    numbers_ = NodeNumbers(std::move(sorted_tags));
    return {};
  }

  /// Group by group, in the order of dimensions and tags.
  Result<void> collect_blocks() {
    std::vector<std::tuple<int, int, std::size_t>> members;
    for (std::size_t b = 0; b < content_.elements.size(); ++b) {
      const MshContent::Elements& elements = content_.elements[b];
      if (elements.groups.empty())
        return config_error(
            "{}: {} elements of kind \"{}\" belong to no named physical group (geometric entity {} of "
            "dimension {})",
            file_, elements.tags.size(), name(elements.kind), elements.entity, dimension(elements.kind));
      for (const int group : elements.groups) members.emplace_back(dimension(elements.kind), group, b);
    }
    if (members.empty())
      return config_error(
          "{}: no element belongs to a named physical group; define physical groups for the volume "
          "or surface and for every boundary in the mesh generator",
          file_);
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
    for (const auto& [dim, group, b] : members) {
      const auto named = content_.group_names.find({dim, group});
      if (named == content_.group_names.end() || named->second.empty())
        return config_error(
            "{}: physical group {} of dimension {} has no name; name it in the mesh generator", file_, group,
            dim);
      const MshContent::Elements& elements = content_.elements[b];
      RawBlock& block = raw_block(named->second, elements.kind);
      block.element_tags.insert(block.element_tags.end(), elements.tags.begin(), elements.tags.end());
      block.node_tags.insert(block.node_tags.end(), elements.nodes.begin(), elements.nodes.end());
    }
    return {};
  }

  RawBlock& raw_block(const std::string& group, ElementKind kind) {
    const auto [found, is_new] = raw_of_.try_emplace({group, kind}, raw_.size());
    return is_new ? raw_.emplace_back(RawBlock{group, kind, {}, {}}) : raw_[found->second];
  }

  /// Elements in the order of their tags, blocks in the order of their first element: the order of the file.
  Result<void> convert_blocks() {
    Tags first_tags;
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

  Result<void> read_field(const std::string& name, const MshContent::Field& raw) {
    NodeField field;
    field.components = raw.components;
    const auto components = static_cast<std::size_t>(raw.components);
    field.values.assign(mesh_.points.size() / 3 * components, std::numeric_limits<double>::quiet_NaN());
    for (std::size_t i = 0; i < raw.nodes.size(); ++i) {
      const auto node = numbers_.index(raw.nodes[i]);
      if (!node)
        return config_error("{}: field \"{}\" has a value on node {}, which is not there", file_, name,
                            raw.nodes[i]);
      std::copy_n(raw.values.begin() + static_cast<std::ptrdiff_t>(i * components), components,
                  field.values.begin() + static_cast<std::ptrdiff_t>(*node) * field.components);
    }
    mesh_.node_fields[name] = std::move(field);
    return {};
  }

  std::string file_;
  MshContent content_;
  Mesh mesh_;
  NodeNumbers numbers_;
  std::vector<RawBlock> raw_;
  std::map<std::pair<std::string, ElementKind>, std::size_t> raw_of_;
};

Result<Mesh> mesh_of(const std::filesystem::path& file, Result<MshContent> content) {
  if (!content) return content.error();
  return Reader(file.string(), std::move(*content)).read();
}

} // namespace

Result<Mesh> read_msh(const std::filesystem::path& file) {
  if (!std::filesystem::is_regular_file(file))
    return config_error("{}: there is no such file", file.string());
  std::ifstream stream(file, std::ios::binary);
  if (!stream) return config_error("{}: the file cannot be read", file.string());
  std::string text(msh_start.size(), '\0');
  stream.read(text.data(), static_cast<std::streamsize>(text.size()));
  text.resize(static_cast<std::size_t>(stream.gcount()));
  if (text != msh_start && file.extension() != ".msh") return mesh_of(file, read_by_gmsh(file.string()));
  text.append(std::istreambuf_iterator<char>(stream.rdbuf()), {});
  return mesh_of(file, parse_msh(file.string(), std::move(text)));
}

} // namespace drogue::mesh
