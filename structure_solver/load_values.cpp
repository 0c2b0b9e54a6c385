// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/load_values.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include <fmt/format.h>

namespace drogue::structure {
namespace {

/// Calls fault(field, text) for whatever has no value, and goes on.
template <class Fault>
LoadValues evaluate(const Model& model, double time, double factor, const Fault& fault) {
  LoadValues values;
  values.time = time;
  values.factor = factor;
  values.force.assign(model.equation_count(), 0.0);
  const auto position = [&](std::int32_t node) {
    return &model.mesh.points[3 * static_cast<std::size_t>(node)];
  };
  const auto check = [&](const auto& load, const config::Expression& value, const double* X, double result) {
    if (!std::isfinite(result))
      fault(load.field, fmt::format("the {}, \"{}\", is {} at x = {}, y = {}, z = {}, t = {}", load.name,
                                    value.text(), result, X[0], X[1], X[2], time));
    return std::isfinite(result);
  };
  for (const WeightedLoad& load : model.loads)
    for (std::size_t k = 0, fine = 1; fine && k < load.nodes.size(); ++k)
      for (std::size_t c = 0; c < 3; ++c) {
        if (load.value[c].is_zero()) continue;
        const double* X = position(load.nodes[k]);
        const double value = load.value[c](X[0], X[1], X[2], time);
        if (!check(load, load.value[c], X, value)) fine = 0;
        values.force[3 * static_cast<std::size_t>(load.nodes[k]) + c] += factor * load.weight[k] * value;
      }
  for (const PressureField& field : model.pressures) {
    std::vector<double>& p = values.pressure.emplace_back(model.node_count(), 0.0);
    if (field.value.is_zero()) continue;
    for (const std::int32_t node : field.nodes) {
      const double* X = position(node);
      const double value = field.value(X[0], X[1], X[2], time);
      p[static_cast<std::size_t>(node)] = factor * value;
      if (!check(field, field.value, X, value)) break;
    }
  }
  values.length_factor.assign(model.batches.size(), 1.0);
  for (const LengthControl& control : model.lengths) {
    const double length = control.schedule(time);
    if (std::isfinite(length) && length > 0)
      values.length_factor[control.batch] = length;
    else
      fault(control.field, fmt::format("the {} is {} times the first one at t = {}; it must be positive",
                                       control.name, length, time));
  }
  return values;
}

} // namespace

LoadValues LoadValues::blend(const LoadValues& a, const LoadValues& b, double alpha) {
  const auto mix = [alpha](double p, double q) { return (1 - alpha) * p + alpha * q; };
  const auto blend_into = [&](const std::vector<double>& p, const std::vector<double>& q,
                              std::vector<double>& r) {
    std::transform(p.begin(), p.end(), q.begin(), r.begin(), mix);
  };
  LoadValues r = a;
  r.time = mix(a.time, b.time);
  r.factor = mix(a.factor, b.factor);
  blend_into(a.force, b.force, r.force);
  for (std::size_t k = 0; k < a.pressure.size(); ++k) blend_into(a.pressure[k], b.pressure[k], r.pressure[k]);
  blend_into(a.length_factor, b.length_factor, r.length_factor);
  return r;
}

Result<LoadValues> evaluate_loads(const Model& model, double time, double factor) {
  std::string first;
  LoadValues values = evaluate(model, time, factor, [&](const std::string&, const std::string& text) {
    if (first.empty()) first = text;
  });
  if (!first.empty()) return numerical_error("{}", first);
  return values;
}

std::vector<double> length_factors(const Model& model, double time) {
  std::vector<double> factors(model.batches.size(), 1.0);
  for (const LengthControl& control : model.lengths)
    if (const double length = control.schedule(time); std::isfinite(length) && length > 0)
      factors[control.batch] = length;
  return factors;
}

std::vector<LoadFault> load_faults(const Model& model, double time) {
  std::vector<LoadFault> faults;
  const auto add = [&](const std::string& field, const std::string& text) {
    if (faults.empty() || faults.back().field != field) faults.push_back({field, text});
  };
  (void)evaluate(model, time, 1, add);
  for (const DragLoad& load : model.drag)
    for (const std::int32_t node : load.nodes)
      for (const config::Expression& air : load.air_velocity) {
        const double* X = &model.mesh.points[3 * static_cast<std::size_t>(node)];
        if (const double value = air(X[0], X[1], X[2], time); !std::isfinite(value))
          add(load.field,
              fmt::format("the air velocity of the {}, \"{}\", is {} at x = {}, y = {}, z = {}, t = {}",
                          load.name, air.text(), value, X[0], X[1], X[2], time));
      }
  return faults;
}

} // namespace drogue::structure
