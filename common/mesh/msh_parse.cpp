// SPDX-License-Identifier: GPL-3.0-or-later
#include <array>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <tuple>

#include "common/mesh/msh_content.hpp"
#include "common/mesh/msh_cursor.hpp"

namespace drogue::mesh {
namespace {

constexpr std::size_t most_groups = 100; ///< of an entity: its elements are copied for each
constexpr int most_components = 9;       ///< of a field: a tensor's

/// Gmsh's names of the types 1 to 19.
constexpr std::array<const char*, 20> type_names{"",
                                                 "Line 2",
                                                 "Triangle 3",
                                                 "Quadrilateral 4",
                                                 "Tetrahedron 4",
                                                 "Hexahedron 8",
                                                 "Prism 6",
                                                 "Pyramid 5",
                                                 "Line 3",
                                                 "Triangle 6",
                                                 "Quadrilateral 9",
                                                 "Tetrahedron 10",
                                                 "Hexahedron 27",
                                                 "Prism 18",
                                                 "Pyramid 14",
                                                 "Point",
                                                 "Quadrilateral 8",
                                                 "Hexahedron 20",
                                                 "Prism 15",
                                                 "Pyramid 13"};

class Parser {
 public:
  Parser(const std::string& file, std::string content) : cursor_(file, std::move(content)) {}

  Result<MshContent> parse() {
    format();
    for (std::string name = cursor_.begin_section(); !name.empty(); name = cursor_.begin_section()) {
      section(name);
      cursor_.end_section();
    }
    if (cursor_.error()) return *cursor_.error();
    give_groups();
    return std::move(content_);
  }

 private:
  void format() {
    cursor_.begin_section();
    const auto version = cursor_.text_number<double>();
    const auto form = cursor_.text_number<int>(), bytes = cursor_.text_number<int>();
    old_ = version >= 2 && version < 3;
    if (!old_ && version != 4.1) cursor_.fail("version {}: save the mesh in version 4.1 or 2.2", version);
    if ((form != 0 && form != 1) || bytes != 8)
      cursor_.fail("form {} and numbers of {} bytes: 0 (text) or 1 (binary), and 8 expected", form, bytes);
    cursor_.end_line();
    cursor_.set_binary(form == 1);
    if (form == 1 && cursor_.number<std::int32_t>() != 1)
      cursor_.fail("the order of the bytes is another machine's: save the mesh as text");
    cursor_.end_section();
  }

  void section(const std::string& name) {
    if (name == "PhysicalNames")
      names();
    else if (name == "Entities" && !old_)
      entities();
    else if (name == "Nodes")
      old_ ? nodes_2() : nodes_4();
    else if (name == "Elements")
      old_ ? elements_2() : elements_4();
    else if (name == "NodeData")
      field();
    else
      cursor_.skip_section();
  }

  std::uint64_t size() { return cursor_.number<std::uint64_t>(); }
  int whole() { return cursor_.number<std::int32_t>(); }
  /// Of a node or an element; binary files of version 2 and all fields have shorter ones.
  std::uint64_t tag(bool is_short) {
    const bool shortened = is_short && cursor_.binary();
    const std::int64_t value = shortened ? whole() : cursor_.number<std::int64_t>();
    if (value < 1) cursor_.fail("number {} of a node or an element: they count from 1", value);
    return static_cast<std::uint64_t>(value);
  }
  bool good() const { return !cursor_.error(); }

  void names() {
    const std::size_t n = cursor_.count(cursor_.text_number<std::uint64_t>(), 2, "names");
    for (std::size_t i = 0; i < n && good(); ++i) {
      const auto dimension = cursor_.text_number<int>(), group = cursor_.text_number<int>();
      content_.group_names[{dimension, group}] = cursor_.quoted();
    }
  }

  void entities() {
    std::array<std::uint64_t, 4> counts{};
    for (std::uint64_t& n : counts) n = size();
    for (int dimension = 0; dimension <= 3; ++dimension) {
      const std::size_t box = dimension == 0 ? 3 : 6;
      const std::size_t n = cursor_.count(counts[static_cast<std::size_t>(dimension)], box + 2, "entities");
      for (std::size_t i = 0; i < n && good(); ++i) {
        std::vector<int>& groups = groups_of_[{dimension, whole()}];
        for (std::size_t k = 0; k < box; ++k) (void)cursor_.number<double>();
        const std::size_t groups_here = cursor_.count(size(), 1, "physical groups");
        if (groups.size() + groups_here > most_groups)
          cursor_.fail("an entity in {} physical groups: at most {} expected", groups.size() + groups_here,
                       most_groups);
        for (std::size_t k = 0; k < groups_here && good(); ++k) groups.push_back(group());
        if (dimension == 0) continue;
        const std::size_t bounds = cursor_.count(size(), 1, "bounding entities");
        for (std::size_t k = 0; k < bounds && good(); ++k) (void)whole();
      }
    }
  }
  /// The sign is an orientation, which belongs to the geometry.
  int group() {
    const int value = whole();
    if (value == std::numeric_limits<int>::min()) cursor_.fail("there is no physical group {}", value);
    return good() ? std::abs(value) : 0;
  }

  void point(std::uint64_t node) {
    content_.node_tags.push_back(node);
    for (int k = 0; k < 3; ++k) {
      content_.points.push_back(cursor_.number<double>());
      if (!std::isfinite(content_.points.back())) cursor_.fail("a coordinate of node {} is not finite", node);
    }
  }

  void nodes_2() {
    const std::size_t n = line_count("nodes", 4);
    for (std::size_t i = 0; i < n && good(); ++i) {
      const std::uint64_t node = tag(true);
      point(node);
    }
  }
  /// A count that is text in both forms and has a line of its own.
  std::size_t line_count(const char* name, std::uint64_t values) {
    const auto n = cursor_.text_number<std::uint64_t>();
    cursor_.end_line();
    return cursor_.count(n, values, name);
  }

  void nodes_4() {
    const std::uint64_t blocks = size(), all = size();
    (void)size(), (void)size();
    (void)cursor_.count(blocks, 4, "blocks of nodes");
    std::uint64_t held = 0;
    std::vector<std::uint64_t> tags;
    for (std::uint64_t b = 0; b < blocks && good(); ++b) {
      const int dimension = whole();
      (void)whole();
      const int parametric = whole();
      if (dimension < 0 || dimension > 3 || parametric < 0 || parametric > 1)
        cursor_.fail("dimension {} and parametric {}: 0 to 3, and 0 or 1 expected", dimension, parametric);
      tags.resize(cursor_.count(size(), 4, "nodes"));
      held += tags.size();
      for (std::uint64_t& t : tags) t = tag(false);
      for (std::size_t i = 0; i < tags.size() && good(); ++i) {
        point(tags[i]);
        for (int k = 0; k < parametric * dimension; ++k) (void)cursor_.number<double>();
      }
    }
    if (held != all) cursor_.fail("{} nodes are announced, {} are there", all, held);
  }

  void elements_2() {
    const std::size_t n = line_count("elements", cursor_.binary() ? 2 : 4);
    for (std::size_t read = 0; read < n && good();) {
      const std::uint64_t first = cursor_.binary() ? 0 : tag(true);
      const std::optional<ElementKind> kind = known_kind(whole());
      const int together = cursor_.binary() ? whole() : 1, marks = whole();
      if (together < 1 || static_cast<std::size_t>(together) > n - read || marks < 0)
        cursor_.fail("{} elements with {} tags each, where {} elements are left", together, marks, n - read);
      if (!good() || !kind) return;
      const auto each =
          static_cast<std::uint64_t>(marks) + static_cast<std::uint64_t>(nodes_per_element(*kind));
      const std::size_t elements = cursor_.count(static_cast<std::uint64_t>(together), each, "elements");
      for (std::size_t e = 0; e < elements && good(); ++e)
        element(cursor_.binary() ? tag(true) : first, *kind, marks);
      read += elements;
    }
  }
  /// Its marks are the physical group, the entity, and what is not needed.
  void element(std::uint64_t element_tag, ElementKind kind, int marks) {
    const int physical = marks > 0 ? group() : 0, entity = marks > 1 ? whole() : 0;
    for (int i = 2; i < marks; ++i) (void)whole();
    const auto [found, is_new] = blocks_.try_emplace({physical, entity, kind}, content_.elements.size());
    if (is_new) {
      content_.elements.push_back({kind, entity, {}, {}, {}});
      if (physical != 0) content_.elements.back().groups = {physical};
    }
    MshContent::Elements& block = content_.elements[found->second];
    block.tags.push_back(element_tag);
    for (int a = 0; a < nodes_per_element(kind); ++a) block.nodes.push_back(tag(true));
  }

  void elements_4() {
    const std::uint64_t blocks = size(), all = size();
    (void)size(), (void)size();
    (void)cursor_.count(blocks, 4, "blocks of elements");
    std::uint64_t held = 0;
    for (std::uint64_t b = 0; b < blocks && good(); ++b) {
      const int dim = whole(), entity = whole();
      const std::optional<ElementKind> kind = known_kind(whole());
      if (!kind) return;
      if (dimension(*kind) != dim)
        cursor_.fail("elements of the kind {} in an entity of dimension {}", name(*kind), dim);
      const auto nodes = static_cast<std::size_t>(nodes_per_element(*kind));
      const std::size_t n = cursor_.count(size(), 1 + nodes, "elements");
      held += n;
      if (n == 0) continue;
      MshContent::Elements& block = content_.elements.emplace_back();
      block.kind = *kind, block.entity = entity;
      block.tags.reserve(n), block.nodes.reserve(n * nodes);
      for (std::size_t e = 0; e < n && good(); ++e) {
        block.tags.push_back(tag(false));
        for (std::size_t a = 0; a < nodes; ++a) block.nodes.push_back(tag(false));
      }
    }
    if (held != all) cursor_.fail("{} elements are announced, {} are there", all, held);
  }

  std::optional<ElementKind> known_kind(int type) {
    const std::optional<ElementKind> kind = good() ? kind_of(type) : std::nullopt;
    const bool named = type > 0 && static_cast<std::size_t>(type) < type_names.size();
    if (!kind)
      cursor_.fail("elements of the unknown kind {} ({}); known are {}", type,
                   named ? type_names[static_cast<std::size_t>(type)] : "not one of Gmsh's first 19",
                   known_kinds);
    return kind;
  }

  void field() {
    const std::size_t strings = cursor_.count(cursor_.text_number<std::uint64_t>(), 1, "names");
    std::string name;
    for (std::size_t i = 0; i < strings && good(); ++i)
      if (const std::string text = cursor_.quoted(); i == 0) name = text;
    const std::size_t reals = cursor_.count(cursor_.text_number<std::uint64_t>(), 1, "real tags");
    for (std::size_t i = 0; i < reals && good(); ++i) (void)cursor_.text_number<double>();
    const std::size_t integers = cursor_.count(cursor_.text_number<std::uint64_t>(), 1, "integer tags");
    std::array<int, 3> header{}; // step, components, nodes
    for (std::size_t i = 0; i < integers && good(); ++i)
      if (const int value = cursor_.text_number<int>(); i < header.size()) header[i] = value;
    const auto [step, components, nodes] = header;
    if (integers < header.size() || components < 1 || components > most_components || nodes < 0)
      cursor_.fail("{} integer tags, {} components on {} nodes: 3 tags, 1 to {} components expected",
                   integers, components, nodes, most_components);
    cursor_.end_line();
    MshContent::Field values{step, components, {}, {}};
    const std::size_t n =
        cursor_.count(static_cast<std::uint64_t>(nodes), 1 + static_cast<std::uint64_t>(components), "nodes");
    for (std::size_t i = 0; i < n && good(); ++i) {
      values.nodes.push_back(tag(true));
      for (int k = 0; k < components; ++k) values.values.push_back(cursor_.number<double>());
    }
    const auto before = content_.fields.find(name);
    if (before == content_.fields.end() || before->second.step <= step)
      content_.fields[name] = std::move(values);
  }

  void give_groups() {
    if (old_) return;
    for (MshContent::Elements& block : content_.elements)
      if (const auto found = groups_of_.find({dimension(block.kind), block.entity});
          found != groups_of_.end())
        block.groups = found->second;
  }

  MshCursor cursor_;
  bool old_ = false; ///< version 2
  MshContent content_;
  std::map<MshContent::DimTag, std::vector<int>> groups_of_;        ///< of an entity; version 4
  std::map<std::tuple<int, int, ElementKind>, std::size_t> blocks_; ///< of group, entity, kind; version 2
};

} // namespace

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

Result<MshContent> parse_msh(const std::string& file, std::string content) {
  if (content.rfind(msh_start, 0) != 0)
    return config_error("{}: it does not begin with $MeshFormat: no mesh file", file);
  return Parser(file, std::move(content)).parse();
}

} // namespace drogue::mesh
