// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/scheme/contract.hpp"

#include <algorithm>

#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

namespace drogue::coupler {
namespace {

template <class List>
const v1::FieldContract* find(const List& list, std::string_view name) {
  for (const v1::FieldContract& f : list)
    if (f.name() == name) return &f;
  return nullptr;
}

Result<void> check_match(const std::string& who, const char* what, const v1::FieldContract& f,
                         const ExpectedField& expected) {
  using C = v1::FieldContract;
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

Result<void> check_contract(const launcher::Peer& peer, const std::vector<ExpectedField>& outputs,
                            const std::vector<ExpectedField>& inputs) {
  for (const ExpectedField& expected : outputs) {
    const v1::FieldContract* f = find_output(peer.hello, expected.name);
    if (!f)
      return config_error("{} does not give \"{}\", which the coupling needs", peer.name, expected.name);
    DROGUE_TRY(check_match(peer.name, "output", *f, expected));
  }
  for (const v1::FieldContract& f : peer.hello.input()) {
    const auto it =
        std::find_if(inputs.begin(), inputs.end(), [&](const auto& e) { return e.name == f.name(); });
    if (it != inputs.end())
      DROGUE_TRY(check_match(peer.name, "input", f, *it));
    else if (!f.optional())
      return config_error("{} needs \"{}\", which the coupler does not have", peer.name, f.name());
  }
  return {};
}

Result<void> check_shape(const std::string& who, const v1::FieldContract& contract,
                         const participant::FloatArray& array, const participant::InterfaceMesh& mesh) {
  const std::uint64_t rows = contract.location() == v1::FieldContract::INTERFACE_NODES
                                 ? mesh.points.size() / 3
                             : contract.location() == v1::FieldContract::MESH_NODES ? mesh.mesh_node_count
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

} // namespace drogue::coupler
