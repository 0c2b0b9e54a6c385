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

/// The reference of a kernel whose elements start from the mesh as it is.
constexpr auto usual_reference = []<class Kernel>(std::type_identity<Kernel>, const auto& X) {
  return Kernel::reference(X);
};

/// Calls f(std::integral_constant<ElementKind, kind>) when `kind` is one that can carry a pressure and has
/// the dimension; false otherwise.
template <class F>
bool with_surface_kind(ElementKind kind, int dimension, const F& f) {
  const auto offer = [&]<ElementKind Kind>(std::type_identity<PressureBatch<Kind>>) {
    const bool found = kind == Kind && ElementTraits<Kind>::dimension == dimension;
    if (found) f(std::integral_constant<ElementKind, Kind>());
    return found;
  };
  return [&]<class... B>(std::type_identity<std::variant<B...>>) {
    return (offer(std::type_identity<B>()) || ...);
  }(std::type_identity<AnyPressureBatch>());
}

/// The kinds of that dimension that can carry a pressure.
std::vector<ElementKind> surface_kinds(int dimension) {
  return dimension == 1
             ? std::vector{ElementKind::line2, ElementKind::line3}
             : std::vector{ElementKind::tri3, ElementKind::tri6, ElementKind::quad4, ElementKind::quad9};
}

/// Adds int N_a dA of the elements of a block to its nodes; on edges int N_a ds.
template <ElementKind Kind>
void add_nodal_areas(const std::vector<double>& points, const ElementBlock& block,
                     std::vector<double>& area) {
  constexpr int n = ElementTraits<Kind>::nodes;
  for (std::int32_t e = 0; e < block.count(); ++e) {
    const auto X = gather<n>(points, block.element(e).data());
    for (const auto& point : element_rule<Kind>().points) {
      const Eigen::Matrix<double, 3, ElementTraits<Kind>::dimension> G = X.lazyProduct(point.dN);
      const double dA = point.weight * std::sqrt((G.transpose() * G).eval().determinant());
      for (int a = 0; a < n; ++a)
        area[static_cast<std::size_t>(block.element(e)[static_cast<std::size_t>(a)])] += point.N(a) * dA;
    }
  }
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
    add_solids();
    add_lines("cable", settings_.cables);
    add_lines("truss", settings_.trusses);
    add_masses();
    add_supports();
    if (settings_.plane) hold_plane();
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

  /// @param wanted  kinds that would do
  void wrong_kind(const std::string& field, const ElementBlock& block,
                  const std::vector<ElementKind>& wanted) {
    std::vector<std::string_view> names;
    for (const ElementKind kind : wanted) names.push_back(mesh::name(kind));
    report_.error(where(field), fmt::format("group \"{}\" holds {} elements; {} elements are needed here",
                                            block.group, mesh::name(block.kind), fmt::join(names, " or ")));
  }

  /// Adds the elements of a group: every block of it by the kernel of that material for the block's kind.
  /// @param reference  makes a kernel's Reference from the reference positions: reference(kernel, X)
  template <class Material, class Reference>
  void add_group(const std::string& field, const std::string& group, const Material& material,
                 const Reference& reference) {
    if (!known(field, group)) return;
    for (const ElementBlock* block : model_.mesh.blocks_of(group)) {
      std::vector<ElementKind> kinds;
      bool added = false;
      for_each_kernel<Material>([&]<class Kernel>(std::type_identity<Kernel> kernel) {
        if (!fits<Kernel>()) return;
        kinds.push_back(Kernel::kind);
        if (block->kind != Kernel::kind) return;
        add_batch<Kernel>(field, *block, material, [&](const auto& X) { return reference(kernel, X); });
        added = true;
      });
      if (!added) wrong_kind(field, *block, kinds);
    }
  }

  /// Solids are surfaces in a plane problem and volumes otherwise.
  template <class Kernel>
  [[nodiscard]] bool fits() const {
    if constexpr (std::is_same_v<typename Kernel::Material, SolidMaterial>)
      return Kernel::dimension == (settings_.plane ? 2 : 3);
    return true;
  }

  template <class Kernel, class Reference>
  void add_batch(const std::string& field, const ElementBlock& block,
                 const typename Kernel::Material& material, const Reference& reference) {
    const auto index = static_cast<std::size_t>(&block - model_.mesh.blocks.data());
    Batch<Kernel> batch{block.group, index, material, block.nodes, {}};
    batch.reference.reserve(static_cast<std::size_t>(block.count()));
    for (std::int32_t e = 0; e < block.count(); ++e) {
      const auto nodes = block.element(e);
      const auto X = gather<Kernel::nodes>(model_.mesh.points, nodes.data());
      batch.reference.push_back(reference(X));
      if (!Kernel::regular(X, batch.reference.back())) {
        report_.error(where(field),
                      fmt::format("element {} of group \"{}\" in {} (nodes {}, the first at ({}, {}, "
                                  "{})) {}",
                                  e, block.group, settings_.mesh.string(), fmt::join(nodes, " "), X(0, 0),
                                  X(1, 0), X(2, 0), Kernel::irregular));
        return;
      }
      const auto m = Kernel::lumped_mass(batch.reference.back(), material);
      for (int a = 0; a < Kernel::nodes; ++a)
        model_.mass[static_cast<std::size_t>(nodes[static_cast<std::size_t>(a)])] += m(a);
    }
    model_.batches.emplace_back(std::move(batch));
  }

  void add_membranes() {
    for (std::size_t i = 0; i < settings_.membranes.size(); ++i)
      add_group(fmt::format("membrane[{}].group", i), settings_.membranes[i].group,
                settings_.membranes[i].material, usual_reference);
  }

  void add_solids() {
    for (std::size_t i = 0; i < settings_.solids.size(); ++i)
      add_group(fmt::format("solid[{}].group", i), settings_.solids[i].group, settings_.solids[i].material,
                usual_reference);
  }

  void add_lines(const char* kind, const std::vector<LineSettings>& lines) {
    for (std::size_t i = 0; i < lines.size(); ++i) {
      const LineSettings& s = lines[i];
      add_group(fmt::format("{}[{}].group", kind, i), s.group, s.material, [&s](auto, const auto& X) {
        return s.natural_length ? Line::Reference{*s.natural_length} : Line::reference(X);
      });
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
      if (settings_.plane) set.held[2] = false; // hold_plane() does
      for (const std::int32_t node : set.nodes)
        for (std::size_t c = 0; c < 3; ++c) {
          if (!set.held[c]) continue;
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

  /// Holds every node in z.
  void hold_plane() {
    const std::vector<double>& X = model_.mesh.points;
    double size = 0;
    for (std::size_t i = 0; i < X.size(); ++i) {
      size = std::max(size, std::abs(X[i] - X[i % 3]));
      if (i % 3 == 2) model_.held[i] = 1;
    }
    for (std::size_t i = 0; i < model_.node_count(); ++i)
      if (!(std::abs(X[3 * i + 2] - X[2]) <= flatness * size)) {
        report_.error(where("plane"),
                      fmt::format("node {} of {} at ({}, {}, {}) lies outside the plane z = {}; a "
                                  "plane problem needs a mesh in one plane",
                                  i, settings_.mesh.string(), X[3 * i], X[3 * i + 1], X[3 * i + 2], X[2]));
        return;
      }
  }

  void add_pressures() {
    for (std::size_t i = 0; i < settings_.pressures.size(); ++i) {
      const PressureSettings& s = settings_.pressures[i];
      const std::string field = fmt::format("pressure[{}].group", i);
      if (!known(field, s.group)) continue;
      const int dimension = settings_.plane ? 1 : 2;
      for (const ElementBlock* block : model_.mesh.blocks_of(s.group)) {
        const bool added = with_surface_kind(block->kind, dimension, [&](auto kind) {
          model_.pressure_batches.emplace_back(
              PressureBatch<decltype(kind)::value>{block->nodes, model_.pressures.size()});
        });
        if (!added) wrong_kind(field, *block, surface_kinds(dimension));
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
      for (const ElementBlock* block : model_.mesh.blocks_of(s.group)) {
        const int dimension = settings_.plane && mesh::dimension(block->kind) == 1 ? 1 : 2;
        const bool added = with_surface_kind(block->kind, dimension, [&](auto kind) {
          add_nodal_areas<decltype(kind)::value>(model_.mesh.points, *block, area);
        });
        if (!added) wrong_kind(field, *block, surface_kinds(dimension));
      }
      WeightedLoad load{model_.mesh.nodes_of(s.group),
                        {},
                        s.value,
                        fmt::format("traction on group \"{}\"", s.group),
                        fmt::format("traction[{}].value", i)};
      for (const std::int32_t node : load.nodes) load.weight.push_back(area[static_cast<std::size_t>(node)]);
      model_.loads.push_back(std::move(load));
    }
  }

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
    const int dimension = settings_.plane ? 1 : 2;
    for (const ElementBlock* block : model_.mesh.blocks_of(name))
      if (!with_surface_kind(block->kind, dimension, [](auto) {}))
        wrong_kind("interface", *block, surface_kinds(dimension));
  }

  void check_every_group_has_a_role() {
    std::vector<std::string> used = settings_.ignored_groups;
    for (const auto& s : settings_.membranes) used.push_back(s.group);
    for (const auto& s : settings_.solids) used.push_back(s.group);
    for (const auto& s : settings_.cables) used.push_back(s.group);
    for (const auto& s : settings_.trusses) used.push_back(s.group);
    for (const auto& s : settings_.masses) used.push_back(s.group);
    for (const auto& s : settings_.supports) used.push_back(s.group);
    for (const auto& s : settings_.forces) used.push_back(s.group);
    // Faces of solids may be named in these alone; without elements their nodes have no mass, which is
    // reported.
    for (const auto& s : settings_.pressures) used.push_back(s.group);
    for (const auto& s : settings_.tractions) used.push_back(s.group);
    used.push_back(settings_.interface);
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
                                  "solid, cable, truss, support or a load, or in ignore_group",
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

  /// How far nodes of a plane mesh may lie outside its plane, relative to its size.
  static constexpr double flatness = 1e-9;

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
