// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <type_traits>
#include <variant>
#include <vector>

#include "structure_solver/elements/line.hpp"
#include "structure_solver/elements/membrane.hpp"
#include "structure_solver/elements/solid.hpp"

namespace drogue::structure {

/// Elements of one kernel that share a material.
template <class Kernel>
struct Batch {
  using KernelType = Kernel;
  std::string group;
  /// Index of the block in mesh::Mesh::blocks.
  std::size_t block = 0;
  typename Kernel::Material material;
  /// Shape {count, Kernel::nodes}.
  std::vector<std::int32_t> nodes;
  std::vector<typename Kernel::Reference> reference;

  [[nodiscard]] std::size_t count() const { return reference.size(); }
  [[nodiscard]] const std::int32_t* element(std::size_t e) const {
    return nodes.data() + e * static_cast<std::size_t>(Kernel::nodes);
  }
};

/// An element's reference with its natural length times `factor`. Only lines have one.
template <class Reference>
[[nodiscard]] const Reference& at_length(const Reference& reference, double /*factor*/) noexcept {
  return reference;
}
[[nodiscard]] inline Line::Reference at_length(const Line::Reference& reference, double factor) noexcept {
  Line::Reference scaled = reference;
  scaled.natural_length *= factor;
  return scaled;
}

/// The registered elements. What a group of the config can be made of follows from this list: the kernels
/// whose Material is the group's, each for its element kind.
using AnyBatch = std::variant<                 //
    Batch<Membrane<mesh::ElementKind::tri3>>,  //
    Batch<Membrane<mesh::ElementKind::tri6>>,  //
    Batch<Membrane<mesh::ElementKind::quad4>>, //
    Batch<Membrane<mesh::ElementKind::quad9>>, //
    Batch<Solid<mesh::ElementKind::tri6>>,     //
    Batch<Solid<mesh::ElementKind::quad9>>,    //
    Batch<Solid<mesh::ElementKind::tet10>>,    //
    Batch<Solid<mesh::ElementKind::hex27>>,    //
    Batch<Line>>;

/// Calls f(std::type_identity<Kernel>) for every registered kernel of a material.
template <class Material, class F>
void for_each_kernel(F&& f) {
  const auto visit = [&]<class Kernel>(std::type_identity<Kernel> kernel) {
    if constexpr (std::is_same_v<typename Kernel::Material, Material>) f(kernel);
  };
  [&]<class... B>(std::type_identity<std::variant<B...>>) {
    (visit(std::type_identity<typename B::KernelType>()), ...);
  }(std::type_identity<AnyBatch>());
}

} // namespace drogue::structure
