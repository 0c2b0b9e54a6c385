// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/conform/inputs.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "coupler/conform/script.hpp"

namespace drogue::coupler::conform {
namespace {

constexpr std::array<double, 3> direction{0.4, -0.2, 0.9};

double along(std::uint64_t component) {
  return component < 3 ? direction[component] : 0;
}

} // namespace

std::uint64_t rows(const v1::FieldContract& field, const Surface& surface) {
  if (field.location() == v1::FieldContract::INTERFACE_NODES) return surface.nodes;
  return field.location() == v1::FieldContract::MESH_NODES ? surface.mesh_nodes : 1;
}

participant::Fields inputs_for(const v1::Hello& hello, const Surface& surface, const Sizes& sizes, int step,
                               int iteration) {
  const double part = static_cast<double>(iteration) / iterations_of_a_step;
  const double increment = sizes.displacement * surface.size;
  const double displacement = increment * (step - 1 + part);
  const double velocity = increment * part / sizes.time_step;
  const double velocity_start = step > 1 ? increment / sizes.time_step : 0;
  const double force = sizes.load * surface.size * surface.size /
                       static_cast<double>(std::max<std::uint64_t>(surface.nodes, 1));
  participant::Fields fields;
  for (const v1::FieldContract& f : hello.input()) {
    participant::FloatArray array{{rows(f, surface), f.components()}, {}};
    for (std::uint64_t node = 0; node < array.shape[0]; ++node)
      for (std::uint64_t c = 0; c < f.components(); ++c) {
        const double varied = (step + part) * (1 + 0.5 * std::sin(1.0 + static_cast<double>(node)));
        double value = 0;
        switch (f.quantity()) {
        case v1::FieldContract::DISPLACEMENT:
        case v1::FieldContract::TRANSLATION:
          value = displacement * along(c);
          break;
        case v1::FieldContract::VELOCITY:
          value = (f.name() == "velocity_start" ? velocity_start : velocity) * along(c);
          break;
        case v1::FieldContract::FORCE:
          value = force * varied * along(c);
          break;
        case v1::FieldContract::PRESSURE:
          value = sizes.load * varied;
          break;
        case v1::FieldContract::TRACTION:
          value = sizes.load * varied * along(c);
          break;
        default:
          break;
        }
        array.values.push_back(value);
      }
    fields[f.name()] = std::move(array);
  }
  return fields;
}

} // namespace drogue::coupler::conform
