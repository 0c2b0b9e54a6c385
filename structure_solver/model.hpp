// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "common/config/config.hpp"
#include "common/config/expression.hpp"
#include "common/mesh/mesh.hpp"
#include "structure_solver/elements/follower_pressure.hpp"
#include "structure_solver/elements/registry.hpp"
#include "structure_solver/load_terms.hpp"
#include "structure_solver/settings.hpp"

namespace drogue::structure {

/// Nodes whose displacement is prescribed in some components.
struct SupportSet {
  std::string group;
  std::array<bool, 3> held{};
  std::vector<std::int32_t> nodes;
  config::VectorExpression displacement;
};

/// Surface elements of one kind under follower pressure; edges in a plane problem.
template <mesh::ElementKind Kind>
struct PressureBatch {
  static constexpr mesh::ElementKind kind = Kind;
  std::vector<std::int32_t> nodes; ///< {count, nodes of Kind}
  /// Which of Model::pressures gives the value.
  std::size_t load = 0;

  [[nodiscard]] std::size_t count() const { return nodes.size() / ElementTraits<Kind>::nodes; }
};
using AnyPressureBatch =
    std::variant<PressureBatch<mesh::ElementKind::line2>, PressureBatch<mesh::ElementKind::line3>,
                 PressureBatch<mesh::ElementKind::tri3>, PressureBatch<mesh::ElementKind::tri6>,
                 PressureBatch<mesh::ElementKind::quad4>, PressureBatch<mesh::ElementKind::quad9>>;

/// Where a pressure acts, and its value as an expression of reference position and time.
struct PressureField {
  std::vector<std::int32_t> nodes;
  config::Expression value;
  std::string name;  ///< for messages, e.g. pressure on "canopy"
  std::string field; ///< its place in the config
};

/// A vector that acts on nodes with a weight each: gravity times mass, traction times area, plain nodal
/// force.
struct WeightedLoad {
  std::vector<std::int32_t> nodes;
  std::vector<double> weight;
  config::VectorExpression value;
  std::string name;
  std::string field;
};

/// The discrete structure: immutable once built.
struct Model {
  mesh::Mesh mesh;
  std::string mesh_hash;
  std::vector<AnyBatch> batches;
  /// Lumped mass of each node [mass].
  std::vector<double> mass;
  std::vector<SupportSet> supports;
  /// 1 where an equation (3 node + component) is held by a support.
  std::vector<std::uint8_t> held;
  std::vector<AnyPressureBatch> pressure_batches;
  std::vector<PressureField> pressures;
  std::vector<WeightedLoad> loads;
  std::vector<DragLoad> drag;
  std::vector<LengthControl> lengths;

  [[nodiscard]] std::size_t node_count() const { return static_cast<std::size_t>(mesh.node_count()); }
  [[nodiscard]] std::size_t equation_count() const { return 3 * node_count(); }
};

/// Builds the model; every mismatch between config and mesh lands in `report` (unknown groups, element kinds
/// that do not fit, degenerate elements, groups without a role), with its position. Empty when there was any.
[[nodiscard]] std::optional<Model> build_model(const Settings& settings, mesh::Mesh mesh,
                                               config::Report& report);

} // namespace drogue::structure
