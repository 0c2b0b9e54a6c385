// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/model.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include <fmt/format.h>

#include "structure_solver/drag_and_lengths.hpp"

namespace drogue::structure {
namespace {

using mesh::ElementBlock;
using mesh::ElementKind;

template <int Nodes>
typename Response<Nodes>::Positions gather(const std::vector<double>& points, const std::int32_t* nodes) {
  typename Response<Nodes>::Positions X;
  for (int a = 0; a < Nodes; ++a)
    X.col(a) = Eigen::Map<const Eigen::Vector3d>(&points[3 * static_cast<std::size_t>(nodes[a])]);
  return X;
}

/// Builds a model step by step, collecting errors.
class Builder {
 public:
  Builder(const Settings& settings, mesh::Mesh mesh, config::Report& report)
      : settings_(settings), report_(report) {
    model_.mesh = std::move(mesh);
    model_.mesh_hash = mesh::hash(model_.mesh);
    model_.mass.assign(model_.node_count(), 0.0);
    model_.held.assign(model_.equation_count(), 0);
    groups_ = model_.mesh.group_names();
  }

  std::optional<Model> build() {
    const std::size_t errors_before = report_.lines().size();
    add_membranes();
    add_lines("cable", settings_.cables);
    add_lines("truss", settings_.trusses);
    add_masses();
    add_supports();
    add_pressures();
    add_tractions();
    add_forces();
    add_gravity();
    add_drag_and_lengths(settings_, report_, model_);
    check_interface();
    check_every_group_has_a_role();
    if (report_.lines().size() == errors_before) check_mass();
    if (report_.lines().size() != errors_before) return std::nullopt;
    return std::move(model_);
  }

 private:
  std::string where(const std::string& path) const { return settings_.source.where(path); }

  /// False (and reported) when the mesh has no such group.
  bool known(const std::string& field, const std::string& group) {
    if (model_.mesh.has_group(group)) return true;
    config::report_unknown_name(report_, where(field), "group", group, settings_.mesh.string(), groups_);
    return false;
  }

  void wrong_kind(const std::string& field, const ElementBlock& block, const char* wanted) {
    report_.error(where(field), fmt::format("group \"{}\" holds {} elements; {} are needed here", block.group,
                                            mesh::name(block.kind), wanted));
  }

  template <class Kernel, class Reference>
  void add_batch(const std::string& field, const ElementBlock& block,
                 const typename Kernel::Material& material, const Reference& reference) {
    const auto index = static_cast<std::size_t>(&block - model_.mesh.blocks.data());
    Batch<Kernel> batch{block.group, index, material, block.nodes, {}};
    for (std::int32_t e = 0; e < block.count(); ++e) {
      const auto nodes = block.element(e);
      batch.reference.push_back(reference(gather<Kernel::nodes>(model_.mesh.points, nodes.data())));
      const auto m = Kernel::lumped_mass(batch.reference.back(), material);
      if (!m.allFinite()) {
        report_.error(where(field),
                      fmt::format("element {} of group \"{}\" in {} is degenerate: it has no area or length",
                                  e, block.group, settings_.mesh.string()));
        return;
      }
      for (int a = 0; a < Kernel::nodes; ++a)
        model_.mass[static_cast<std::size_t>(nodes[static_cast<std::size_t>(a)])] += m(a);
    }
    model_.batches.emplace_back(std::move(batch));
  }

  template <ElementKind Kind>
  void add_membrane_block(const std::string& field, const ElementBlock& block,
                          const MembraneMaterial& material) {
    using Kernel = Membrane<Kind>;
    add_batch<Kernel>(field, block, material, [](const auto& X) { return Kernel::reference(X); });
  }

  void add_membranes() {
    for (std::size_t i = 0; i < settings_.membranes.size(); ++i) {
      const MembraneSettings& s = settings_.membranes[i];
      const std::string field = fmt::format("membrane[{}].group", i);
      if (!known(field, s.group)) continue;
      for (const ElementBlock* block : model_.mesh.blocks_of(s.group)) {
        if (block->kind == ElementKind::tri3)
          add_membrane_block<ElementKind::tri3>(field, *block, s.material);
        else if (block->kind == ElementKind::quad9)
          add_membrane_block<ElementKind::quad9>(field, *block, s.material);
        else
          wrong_kind(field, *block, "3-node triangles or 9-node quadrilaterals");
      }
    }
  }

  void add_lines(const char* kind, const std::vector<LineSettings>& lines) {
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const LineSettings& s = lines[i];
      const std::string field = fmt::format("{}[{}].group", kind, i);
      if (!known(field, s.group)) continue;
      for (const ElementBlock* block : model_.mesh.blocks_of(s.group)) {
        if (block->kind != ElementKind::line2) {
          wrong_kind(field, *block, "2-node lines");
          continue;
        }
        add_batch<Line>(field, *block, s.material, [&s](const auto& X) {
          return s.natural_length ? Line::Reference{*s.natural_length} : Line::reference(X);
        });
        const auto& batch = std::get<Batch<Line>>(model_.batches.back());
        for (std::size_t e = 0; e < batch.count(); ++e)
          if (!(batch.reference[e].natural_length > 0)) {
            report_.error(where(field),
                          fmt::format("element {} of group \"{}\" in {} has length zero; give natural_length",
                                      e, s.group, settings_.mesh.string()));
            break;
          }
      }
    }
  }

  void add_masses() {
    for (std::size_t i = 0; i < settings_.masses.size(); ++i) {
      if (!known(fmt::format("mass[{}].group", i), settings_.masses[i].group)) continue;
      for (const std::int32_t node : model_.mesh.nodes_of(settings_.masses[i].group))
        model_.mass[static_cast<std::size_t>(node)] += settings_.masses[i].mass;
    }
  }

  void add_supports() {
    for (std::size_t i = 0; i < settings_.supports.size(); ++i) {
      const SupportSettings& s = settings_.supports[i];
      const std::string field = fmt::format("support[{}].group", i);
      if (!known(field, s.group)) continue;
      SupportSet set{s.group, s.held, model_.mesh.nodes_of(s.group), s.displacement};
      for (const std::int32_t node : set.nodes)
        for (std::size_t c = 0; c < 3; ++c) {
          if (!s.held[c]) continue;
          std::uint8_t& held = model_.held[3 * static_cast<std::size_t>(node) + c];
          if (held) {
            report_.error(where(field),
                          fmt::format("node {} of group \"{}\" is already held in {} by another support",
                                      node, s.group, "xyz"[c]));
            return;
          }
          held = 1;
        }
      model_.supports.push_back(std::move(set));
    }
  }

  void add_pressures() {
    for (std::size_t i = 0; i < settings_.pressures.size(); ++i) {
      const PressureSettings& s = settings_.pressures[i];
      const std::string field = fmt::format("pressure[{}].group", i);
      if (!known(field, s.group)) continue;
      for (const ElementBlock* block : model_.mesh.blocks_of(s.group)) {
        if (block->kind == ElementKind::tri3)
          model_.pressure_batches.emplace_back(
              PressureBatch<ElementKind::tri3>{block->nodes, model_.pressures.size()});
        else if (block->kind == ElementKind::quad9)
          model_.pressure_batches.emplace_back(
              PressureBatch<ElementKind::quad9>{block->nodes, model_.pressures.size()});
        else
          wrong_kind(field, *block, "3-node triangles or 9-node quadrilaterals");
      }
      model_.pressures.push_back({model_.mesh.nodes_of(s.group), s.value,
                                  fmt::format("pressure on group \"{}\"", s.group),
                                  fmt::format("pressure[{}].value", i)});
    }
  }

  /// Tractions act with the nodes' reference areas: int N_a t dA by the lumped rule, exact for constants.
  void add_tractions() {
    for (std::size_t i = 0; i < settings_.tractions.size(); ++i) {
      const VectorLoadSettings& s = settings_.tractions[i];
      const std::string field = fmt::format("traction[{}].group", i);
      if (!known(field, s.group)) continue;
      std::vector<double> area(model_.node_count(), 0.0);
      bool found = false;
      for (const AnyBatch& any : model_.batches)
        std::visit([&](const auto& batch) { found |= add_area(batch, s.group, area); }, any);
      if (!found)
        report_.error(where(field),
                      fmt::format("group \"{}\" is not a membrane; a traction needs one", s.group));
      WeightedLoad load{model_.mesh.nodes_of(s.group),
                        {},
                        s.value,
                        fmt::format("traction on group \"{}\"", s.group),
                        fmt::format("traction[{}].value", i)};
      for (const std::int32_t node : load.nodes) load.weight.push_back(area[static_cast<std::size_t>(node)]);
      model_.loads.push_back(std::move(load));
    }
  }

  template <class Kernel>
  static bool add_area(const Batch<Kernel>& batch, const std::string& group, std::vector<double>& area) {
    if (batch.group != group) return false;
    if constexpr (mesh_dimension<Kernel> == 2) {
      for (std::size_t e = 0; e < batch.count(); ++e)
        for (int a = 0; a < Kernel::nodes; ++a)
          area[static_cast<std::size_t>(batch.element(e)[a])] += batch.reference[e].nodal_area(a);
      return true;
    }
    return false;
  }
  template <class Kernel>
  static constexpr int mesh_dimension = Kernel::kind == ElementKind::line2 ? 1 : 2;

  void add_forces() {
    for (std::size_t i = 0; i < settings_.forces.size(); ++i) {
      const VectorLoadSettings& s = settings_.forces[i];
      if (!known(fmt::format("force[{}].group", i), s.group)) continue;
      WeightedLoad load{model_.mesh.nodes_of(s.group),
                        {},
                        s.value,
                        fmt::format("force on group \"{}\"", s.group),
                        fmt::format("force[{}].value", i)};
      load.weight.assign(load.nodes.size(), 1.0);
      model_.loads.push_back(std::move(load));
    }
  }

  void add_gravity() {
    const auto& g = settings_.gravity;
    if (g[0].is_zero() && g[1].is_zero() && g[2].is_zero()) return;
    WeightedLoad load{std::vector<std::int32_t>(model_.node_count()), model_.mass, g, "gravity", "gravity"};
    std::iota(load.nodes.begin(), load.nodes.end(), 0);
    model_.loads.push_back(std::move(load));
  }

  void check_interface() {
    const std::string& name = settings_.interface;
    if (name.empty() || !known("interface", name)) return;
    const bool membrane = std::any_of(settings_.membranes.begin(), settings_.membranes.end(),
                                      [&](const MembraneSettings& m) { return m.group == name; });
    if (!membrane)
      report_.error(where("interface"), fmt::format("group \"{}\" is not a membrane of this config", name));
  }

  void check_every_group_has_a_role() {
    std::vector<std::string> used = settings_.ignored_groups;
    for (const auto& s : settings_.membranes) used.push_back(s.group);
    for (const auto& s : settings_.cables) used.push_back(s.group);
    for (const auto& s : settings_.trusses) used.push_back(s.group);
    for (const auto& s : settings_.masses) used.push_back(s.group);
    for (const auto& s : settings_.supports) used.push_back(s.group);
    for (const auto& s : settings_.forces) used.push_back(s.group);
    for (std::size_t i = 0; i < settings_.ignored_groups.size(); ++i)
      known(fmt::format("ignore_group[{}]", i), settings_.ignored_groups[i]);
    for (const std::string& group : groups_) {
      const auto blocks = model_.mesh.blocks_of(group);
      // Points are labels: they need no role.
      const bool labels = std::all_of(blocks.begin(), blocks.end(),
                                      [](const ElementBlock* b) { return b->kind == ElementKind::point1; });
      if (!labels && std::find(used.begin(), used.end(), group) == used.end())
        report_.error(where("mesh"),
                      fmt::format("group \"{}\" of {} has no role in this config; name it in membrane, "
                                  "cable, truss, support or force, or in ignore_group",
                                  group, settings_.mesh.string()));
    }
  }

  /// A free node without mass has no equation of motion.
  void check_mass() {
    for (std::size_t i = 0; i < model_.node_count(); ++i) {
      const bool free = !(model_.held[3 * i] && model_.held[3 * i + 1] && model_.held[3 * i + 2]);
      if (!free || model_.mass[i] > 0) continue;
      report_.error(
          where("mesh"),
          fmt::format("node {} at ({}, {}, {}) is free but has no mass: give its elements a density, "
                      "or hold it",
                      i, model_.mesh.points[3 * i], model_.mesh.points[3 * i + 1],
                      model_.mesh.points[3 * i + 2]));
      return;
    }
  }

  const Settings& settings_;
  config::Report& report_;
  Model model_;
  std::vector<std::string> groups_;
};

} // namespace

std::optional<Model> build_model(const Settings& settings, mesh::Mesh mesh, config::Report& report) {
  return Builder(settings, std::move(mesh), report).build();
}

} // namespace drogue::structure
