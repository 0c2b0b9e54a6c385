// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/extension.hpp"

#include "mesh_mover/algebraic_extension.hpp"
#include "mesh_mover/elastic_extension.hpp"

namespace drogue::mesh_mover {

std::unique_ptr<Extension> make_extension(const Settings& settings, const Cells& cells,
                                          const BoundaryMotion& motion,
                                          std::span<const double> initial_jacobians) {
  if (settings.method == Method::algebraic)
    return std::make_unique<AlgebraicExtension>(settings, cells, motion);
  return std::make_unique<ElasticExtension>(settings, cells, motion, initial_jacobians);
}

} // namespace drogue::mesh_mover
