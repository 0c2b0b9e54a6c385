// SPDX-License-Identifier: GPL-3.0-or-later
#include "coupler/acceleration/accelerator.hpp"

#include <cmath>

#include "coupler/acceleration/iqn_ils.hpp"
#include "coupler/acceleration/relaxation.hpp"

namespace drogue::acceleration {

Result<std::unique_ptr<Accelerator>> make_accelerator(const Settings& s, std::size_t n, std::size_t passenger,
                                                      std::span<const double> weights) {
  if (n == 0) return config_error("acceleration: the interface has no unknowns");
  if (!(s.relaxation > 0)) return config_error("acceleration.relaxation = {}: must be above 0", s.relaxation);
  if (!(s.max_relaxation > 0))
    return config_error("acceleration.max_relaxation = {}: must be above 0", s.max_relaxation);
  if (s.reuse_steps < 0)
    return config_error("acceleration.reuse_steps = {}: must not be negative", s.reuse_steps);
  if (!(s.filter > 0 && s.filter < 1))
    return config_error("acceleration.filter = {}: must lie between 0 and 1", s.filter);
  if (s.max_columns < 1)
    return config_error("acceleration.max_columns = {}: must be at least 1", s.max_columns);
  if (!weights.empty() && weights.size() != n)
    return config_error("acceleration: {} weights for {} unknowns", weights.size(), n);
  for (std::size_t i = 0; i < weights.size(); ++i)
    if (!(weights[i] > 0) || !std::isfinite(weights[i]))
      return config_error("acceleration: weight {} is {}: must be positive and finite", i, weights[i]);

  std::unique_ptr<Accelerator> made;
  switch (s.method) {
  case Method::constant:
    made = std::make_unique<ConstantRelaxation>(s.relaxation);
    break;
  case Method::aitken:
    made = std::make_unique<AitkenRelaxation>(s, weights, n);
    break;
  case Method::iqn_ils:
  case Method::iqn_imvj:
    made = std::make_unique<IqnIls>(s, weights, n, passenger);
    break;
  }
  return made;
}

} // namespace drogue::acceleration
