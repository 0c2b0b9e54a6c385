// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/scheme/contract.hpp"

#include <algorithm>
#include <map>

#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

namespace drogue::coupler {
namespace {

using C = v1::FieldContract;

/// A field as the coupler understands it.
struct ExpectedField {
  std::string_view name;
  C::Quantity quantity;
  C::Location location;
  std::uint32_t components;
  C::TimeLevel time_level;
};

struct RoleContract {
  std::vector<ExpectedField> outputs; ///< each must be given
  std::vector<ExpectedField> inputs;  ///< what the coupler has
};

RoleContract contract_of(const std::string& role) {
  if (role == "structure")
    return {{{"displacement", C::DISPLACEMENT, C::INTERFACE_NODES, 3, C::END_OF_STEP},
             {"velocity", C::VELOCITY, C::INTERFACE_NODES, 3, C::END_OF_STEP}},
            {{"force", C::FORCE, C::INTERFACE_NODES, 3, C::END_OF_STEP},
             {"traction", C::TRACTION, C::INTERFACE_NODES, 3, C::END_OF_STEP},
             {"displacement", C::DISPLACEMENT, C::INTERFACE_NODES, 3, C::END_OF_STEP}}};
  if (role == "mesh_mover")
    return {{{"mesh_displacement", C::DISPLACEMENT, C::MESH_NODES, 3, C::END_OF_STEP}},
            {{"displacement", C::DISPLACEMENT, C::INTERFACE_NODES, 3, C::END_OF_STEP},
             {"translation", C::TRANSLATION, C::GLOBAL, 3, C::END_OF_STEP}}};
  return {{},
          {{"mesh_displacement", C::DISPLACEMENT, C::MESH_NODES, 3, C::END_OF_STEP},
           {"velocity", C::VELOCITY, C::INTERFACE_NODES, 3, C::END_OF_STEP},
           {"velocity_start", C::VELOCITY, C::INTERFACE_NODES, 3, C::END_OF_STEP}}};
}

template <class List>
const v1::FieldContract* find(const List& list, std::string_view name) {
  for (const v1::FieldContract& f : list)
    if (f.name() == name) return &f;
  return nullptr;
}

Result<void> check_match(const std::string& who, const char* what, const v1::FieldContract& f,
                         const ExpectedField& expected) {
  const auto describe = [](C::Quantity q, C::Location l, std::uint32_t components, C::TimeLevel t) {
    return fmt::format("{} at {}, {} components, {}", C::Quantity_Name(q), C::Location_Name(l), components,
                       C::TimeLevel_Name(t));
  };
  if (f.quantity() == expected.quantity && f.location() == expected.location &&
      f.components() == expected.components && f.time_level() == expected.time_level)
    return {};
  return config_error(
      "{}: {} \"{}\" is declared as {}; the coupler has {}", who, what, f.name(),
      describe(f.quantity(), f.location(), f.components(), f.time_level()),
      describe(expected.quantity, expected.location, expected.components, expected.time_level));
}

} // namespace

const v1::FieldContract* find_input(const v1::Hello& hello, std::string_view name) {
  return find(hello.input(), name);
}
const v1::FieldContract* find_output(const v1::Hello& hello, std::string_view name) {
  return find(hello.output(), name);
}

Result<void> check_role(const std::string& role, const std::string& who, const v1::Hello& hello) {
  const RoleContract contract = contract_of(role);
  for (const ExpectedField& expected : contract.outputs) {
    const v1::FieldContract* f = find_output(hello, expected.name);
    if (!f) return config_error("{} does not give \"{}\", which the coupling needs", who, expected.name);
    DROGUE_TRY(check_match(who, "output", *f, expected));
  }
  for (const v1::FieldContract& f : hello.input()) {
    const auto it = std::find_if(contract.inputs.begin(), contract.inputs.end(),
                                 [&](const auto& e) { return e.name == f.name(); });
    if (it != contract.inputs.end())
      DROGUE_TRY(check_match(who, "input", f, *it));
    else if (!f.optional())
      return config_error("{} needs \"{}\", which the coupler does not have", who, f.name());
  }
  if (role == "structure" && !find_input(hello, "force") && !find_input(hello, "traction"))
    return config_error("{} takes neither \"force\" nor \"traction\": it cannot be loaded", who);
  return {};
}

Result<void> check_shape(const std::string& who, const v1::FieldContract& contract,
                         const participant::FloatArray& array, const MeshSize& size) {
  const std::uint64_t rows = contract.location() == v1::FieldContract::INTERFACE_NODES ? size.interface_nodes
                             : contract.location() == v1::FieldContract::MESH_NODES    ? size.mesh_nodes
                                                                                       : 1;
  const std::vector<std::uint64_t> expected{rows, contract.components()};
  if (array.shape == expected) return {};
  return peer_error("{} gave \"{}\" with shape {{{}}}, expected {{{}}}", who, contract.name(),
                    fmt::join(array.shape, ", "), fmt::join(expected, ", "));
}

Result<void> check_same_mesh(const participant::InterfaceMesh& fluid,
                             const participant::InterfaceMesh& mesh_mover) {
  if (fluid.mesh_node_count != mesh_mover.mesh_node_count)
    return config_error("fluid and mesh_mover hold different meshes: {} and {} nodes", fluid.mesh_node_count,
                        mesh_mover.mesh_node_count);
  if (fluid.mesh_hash.empty() || mesh_mover.mesh_hash.empty())
    spdlog::warn("fluid or mesh_mover gives no mesh hash: only the number of nodes was compared");
  else if (fluid.mesh_hash != mesh_mover.mesh_hash)
    return config_error("fluid and mesh_mover hold different meshes (hashes {} and {})", fluid.mesh_hash,
                        mesh_mover.mesh_hash);
  std::vector<std::int64_t> a = fluid.mesh_nodes, b = mesh_mover.mesh_nodes;
  if (a.size() != fluid.points.size() / 3)
    return config_error("fluid must give mesh_nodes for its interface");
  std::sort(a.begin(), a.end());
  std::sort(b.begin(), b.end());
  if (a != b)
    return config_error("fluid and mesh_mover name different interface nodes ({} and {})", a.size(),
                        b.size());
  return {};
}

Result<void> check_same_pairs(const MeshHolders& before, const MeshHolders& after) {
  std::map<std::int64_t, std::size_t> fluid_index;
  for (std::size_t i = 0; i < before.fluid.mesh_nodes.size(); ++i)
    fluid_index[before.fluid.mesh_nodes[i]] = i;
  if (after.fluid.mesh_nodes.size() != before.fluid.mesh_nodes.size() ||
      after.mesh_mover.mesh_nodes.size() != before.mesh_mover.mesh_nodes.size())
    return peer_error("fluid or mesh_mover has another number of interface nodes on the new mesh");
  for (std::size_t i = 0; i < before.mesh_mover.mesh_nodes.size(); ++i)
    if (after.fluid.mesh_nodes[fluid_index.at(before.mesh_mover.mesh_nodes[i])] !=
        after.mesh_mover.mesh_nodes[i])
      return peer_error(
          "fluid or mesh_mover has its interface nodes in another order on the new mesh (node {})", i);
  return {};
}

} // namespace drogue::coupler
