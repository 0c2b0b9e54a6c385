// SPDX-License-Identifier: GPL-3.0-or-later
//
// MSH 4.1 binary, written directly: one entity and one physical group for every group and dimension, all
// nodes in one block with tags 1..n, elements with consecutive tags in the order of the mesh's blocks.
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "common/io/atomic_file.hpp"
#include "common/mesh/msh.hpp"

namespace drogue::mesh {
namespace {

constexpr int gmsh_type(ElementKind kind) {
  switch (kind) {
  case ElementKind::point1:
    return 15;
  case ElementKind::line2:
    return 1;
  case ElementKind::line3:
    return 8;
  case ElementKind::tri3:
    return 2;
  case ElementKind::tri6:
    return 9;
  case ElementKind::quad4:
    return 3;
  case ElementKind::quad9:
    return 10;
  case ElementKind::tet4:
    return 4;
  case ElementKind::tet10:
    return 11;
  case ElementKind::hex27:
    return 12;
  }
  return 0;
}

/// A group in one dimension: the geometric entity and the physical group, both of that tag.
struct Entity {
  int dimension = 0;
  int tag = 0;
  std::string group;
  std::array<double, 3> lower;
  std::array<double, 3> upper;
};

class Bytes {
 public:
  template <class T>
  Bytes& add(T value) {
    text_.append(reinterpret_cast<const char*>(&value), sizeof value);
    return *this;
  }
  Bytes& text(std::string_view text) {
    text_ += text;
    return *this;
  }
  [[nodiscard]] const std::string& str() const { return text_; }

 private:
  std::string text_;
};

Entity& entity_of(std::vector<Entity>& entities, const ElementBlock& block) {
  const int dim = dimension(block.kind);
  for (Entity& entity : entities)
    if (entity.dimension == dim && entity.group == block.group) return entity;
  const auto same =
      std::count_if(entities.begin(), entities.end(), [&](const Entity& e) { return e.dimension == dim; });
  Entity entity{dim, static_cast<int>(same) + 1, block.group, {}, {}};
  entity.lower.fill(std::numeric_limits<double>::infinity());
  entity.upper.fill(-std::numeric_limits<double>::infinity());
  return entities.emplace_back(entity);
}

std::vector<Entity> entities_of(const Mesh& mesh) {
  std::vector<Entity> entities;
  for (const ElementBlock& block : mesh.blocks) {
    Entity& entity = entity_of(entities, block);
    for (const std::int32_t node : block.nodes)
      for (std::size_t k = 0; k < 3; ++k) {
        const double x = mesh.points[3 * static_cast<std::size_t>(node) + k];
        entity.lower[k] = std::min(entity.lower[k], x);
        entity.upper[k] = std::max(entity.upper[k], x);
      }
  }
  return entities;
}

bool bad_name(const std::string& name) {
  return name.empty() || name.size() > 127 || name.find_first_of("\"\n\r") != std::string::npos;
}

Result<void> check(const std::filesystem::path& file, const Mesh& mesh) {
  const auto refuse = [&](const std::string& why) {
    return internal_error("cannot write {}: {}", file.string(), why);
  };
  if (mesh.blocks.empty()) return refuse("the mesh has no elements");
  for (const ElementBlock& block : mesh.blocks) {
    if (bad_name(block.group)) return refuse(fmt::format("group name \"{}\" is not allowed", block.group));
    if (block.nodes.empty()) return refuse(fmt::format("group \"{}\" has no elements", block.group));
    for (const std::int32_t node : block.nodes)
      if (node < 0 || node >= mesh.node_count())
        return refuse(fmt::format("group \"{}\" uses node {} of {}", block.group, node, mesh.node_count()));
  }
  for (const auto& [name, field] : mesh.node_fields) {
    if (bad_name(name)) return refuse(fmt::format("field name \"{}\" is not allowed", name));
    if (field.components < 1 ||
        field.values.size() != static_cast<std::size_t>(field.components) * (mesh.points.size() / 3))
      return refuse(fmt::format("field \"{}\" has {} values for {} nodes", name, field.values.size(),
                                mesh.node_count()));
  }
  return {};
}

void add_names(Bytes& out, const std::vector<Entity>& entities) {
  out.text(fmt::format("$PhysicalNames\n{}\n", entities.size()));
  for (const Entity& e : entities) out.text(fmt::format("{} {} \"{}\"\n", e.dimension, e.tag, e.group));
  out.text("$EndPhysicalNames\n");
}

void add_entities(Bytes& out, const std::vector<Entity>& entities) {
  out.text("$Entities\n");
  for (int dim = 0; dim <= 3; ++dim)
    out.add<std::uint64_t>(static_cast<std::uint64_t>(std::count_if(
        entities.begin(), entities.end(), [&](const Entity& e) { return e.dimension == dim; })));
  for (int dim = 0; dim <= 3; ++dim)
    for (const Entity& e : entities) {
      if (e.dimension != dim) continue;
      out.add<std::int32_t>(e.tag);
      for (const double x : e.lower) out.add(x);
      if (dim > 0)
        for (const double x : e.upper) out.add(x);
      out.add<std::uint64_t>(1).add<std::int32_t>(e.tag);
      if (dim > 0) out.add<std::uint64_t>(0);
    }
  out.text("\n$EndEntities\n");
}

void add_nodes(Bytes& out, const Mesh& mesh, const std::vector<Entity>& entities) {
  const Entity& owner =
      *std::max_element(entities.begin(), entities.end(),
                        [](const Entity& a, const Entity& b) { return a.dimension < b.dimension; });
  const auto count = static_cast<std::uint64_t>(mesh.node_count());
  out.text("$Nodes\n").add<std::uint64_t>(1).add(count).add<std::uint64_t>(1).add(count);
  out.add<std::int32_t>(owner.dimension).add<std::int32_t>(owner.tag).add<std::int32_t>(0).add(count);
  for (std::uint64_t i = 1; i <= count; ++i) out.add(i);
  for (const double x : mesh.points) out.add(x);
  out.text("\n$EndNodes\n");
}

void add_elements(Bytes& out, const Mesh& mesh, std::vector<Entity>& entities) {
  std::uint64_t count = 0;
  for (const ElementBlock& block : mesh.blocks) count += static_cast<std::uint64_t>(block.count());
  out.text("$Elements\n").add<std::uint64_t>(mesh.blocks.size()).add(count).add<std::uint64_t>(1).add(count);
  std::uint64_t tag = 1;
  for (const ElementBlock& block : mesh.blocks) {
    const Entity& entity = entity_of(entities, block);
    out.add<std::int32_t>(entity.dimension)
        .add<std::int32_t>(entity.tag)
        .add<std::int32_t>(gmsh_type(block.kind));
    out.add(static_cast<std::uint64_t>(block.count()));
    for (std::int32_t e = 0; e < block.count(); ++e) {
      out.add(tag++);
      for (const std::int32_t node : block.element(e)) out.add(static_cast<std::uint64_t>(node) + 1);
    }
  }
  out.text("\n$EndElements\n");
}

void add_field(Bytes& out, const std::string& name, const NodeField& field) {
  const auto components = static_cast<std::size_t>(field.components);
  std::vector<std::size_t> nodes;
  for (std::size_t i = 0; i < field.values.size() / components; ++i) {
    const auto values = std::span(field.values).subspan(i * components, components);
    if (!std::all_of(values.begin(), values.end(), [](double v) { return std::isnan(v); }))
      nodes.push_back(i);
  }
  out.text(fmt::format("$NodeData\n1\n\"{}\"\n1\n0\n3\n0\n{}\n{}\n", name, components, nodes.size()));
  for (const std::size_t i : nodes) {
    out.add(static_cast<std::int32_t>(i) + 1);
    for (std::size_t k = 0; k < components; ++k) out.add(field.values[i * components + k]);
  }
  out.text("\n$EndNodeData\n");
}

} // namespace

Result<void> write_msh(const std::filesystem::path& file, const Mesh& mesh) {
  DROGUE_TRY(check(file, mesh));
  std::vector<Entity> entities = entities_of(mesh);
  Bytes out;
  out.text("$MeshFormat\n4.1 1 8\n").add<std::int32_t>(1).text("\n$EndMeshFormat\n");
  add_names(out, entities);
  add_entities(out, entities);
  add_nodes(out, mesh, entities);
  add_elements(out, mesh, entities);
  for (const auto& [name, field] : mesh.node_fields) add_field(out, name, field);
  return io::write_file(file, out.str());
}

} // namespace drogue::mesh
