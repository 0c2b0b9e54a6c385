// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include "structure_solver/elements/line.hpp"
#include "structure_solver/elements/membrane.hpp"

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

/// The registered elements.
using AnyBatch = std::variant<                 //
    Batch<Membrane<mesh::ElementKind::tri3>>,  //
    Batch<Membrane<mesh::ElementKind::quad9>>, //
    Batch<Line>>;

} // namespace drogue::structure
