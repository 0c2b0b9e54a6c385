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

/// The registered elements.
using AnyBatch = std::variant<                 //
    Batch<Membrane<mesh::ElementKind::tri3>>,  //
    Batch<Membrane<mesh::ElementKind::quad9>>, //
    Batch<Line>>;

} // namespace drogue::structure
