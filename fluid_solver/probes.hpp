// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>
#include <span>
#include <vector>

#include "common/base/result.hpp"
#include "fluid_solver/fluid_mesh.hpp"
#include "fluid_solver/settings.hpp"

namespace drogue::fluid {

/// Points that stay with the element in which they lie at the start.
class Probes {
 public:
  Probes() = default;
  /// Errors (ErrorKind::config): a point outside the fluid.
  [[nodiscard]] static Result<Probes> create(const std::vector<ProbeSettings>& wanted, const FluidMesh& mesh);
  /// u_x, u_y, u_z, p of each probe; p {n} multiplied by density.
  [[nodiscard]] std::vector<double> values(std::span<const double> u, std::span<const double> p,
                                           double density) const;

  /// Where they are when the nodes are at x {n, 3}.
  [[nodiscard]] std::vector<std::array<double, 3>> positions(std::span<const double> x) const;

 private:
  struct Place {
    std::array<std::int32_t, 4> nodes{};
    std::array<double, 4> weight{};
  };
  std::vector<Place> places_;
};

} // namespace drogue::fluid
