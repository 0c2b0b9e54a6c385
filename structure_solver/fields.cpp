// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/fields.hpp"

#include <algorithm>
#include <limits>

#include <Eigen/Eigenvalues>

#include "structure_solver/load_values.hpp"

namespace drogue::structure {
namespace {

template <class Kernel>
typename Kernel::Positions positions(const Model& model, std::span<const double> u,
                                     const std::int32_t* nodes) {
  typename Kernel::Positions x;
  for (int a = 0; a < Kernel::nodes; ++a)
    for (int c = 0; c < 3; ++c) {
      const std::size_t i = 3 * static_cast<std::size_t>(nodes[a]) + static_cast<std::size_t>(c);
      x(c, a) = model.mesh.points[i] + u[i];
    }
  return x;
}

struct Sums {
  StressFields fields;
  std::vector<double> weight; // of the nodal means
  std::size_t cables = 0, slack = 0;
  double area = 0, wrinkled_area = 0;
  double max_stress = -std::numeric_limits<double>::infinity();
  double min_stress = std::numeric_limits<double>::infinity();
};

/// Mean of axes, vectors whose sign has no meaning: the first eigenvector of the sum of w d d^T. Its largest
/// component is positive.
class AxisMean {
 public:
  void add(const Eigen::Vector3d& d, double weight) { sum_ += weight * d * d.transpose(); }
  void append_to(std::vector<double>& out) const {
    Eigen::Vector3d axis = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(sum_).eigenvectors().col(2);
    Eigen::Index largest = 0;
    axis.cwiseAbs().maxCoeff(&largest);
    if (axis(largest) < 0) axis = -axis;
    out.insert(out.end(), axis.begin(), axis.end());
  }

 private:
  Eigen::Matrix3d sum_ = Eigen::Matrix3d::Zero();
};

template <class Kernel>
constexpr bool is_membrane = std::is_same_v<typename Kernel::Material, MembraneMaterial>;

/// Membranes and solids.
template <class Kernel>
void add(const Batch<Kernel>& batch, const Model& model, std::span<const double> u, double /*length*/,
         Sums& sums) {
  const auto& rule = element_rule<Kernel::kind>();
  for (std::size_t e = 0; e < batch.count(); ++e) {
    const auto& reference = batch.reference[e];
    const auto x = positions<Kernel>(model, u, batch.element(e));
    double total = 0, largest = 0, smallest = 0, state = 0;
    AxisMean largest_axis, smallest_axis;
    for (std::size_t q = 0; q < Kernel::points; ++q) {
      const auto at = Kernel::point_state(reference, batch.material, x, q);
      const PrincipalStress p = Kernel::principal_stress(at);
      sums.max_stress = std::max(sums.max_stress, p.largest);
      sums.min_stress = std::min(sums.min_stress, p.smallest);
      const double dV = reference.measure[q];
      total += dV;
      largest += p.largest * dV;
      smallest += p.smallest * dV;
      largest_axis.add(p.largest_direction, dV);
      smallest_axis.add(p.smallest_direction, dV);
      if constexpr (is_membrane<Kernel>) {
        state += static_cast<double>(at.wrinkle_state) * dV;
        if (at.wrinkle_state != WrinkleState::taut) sums.wrinkled_area += dV;
      } else {
        state += static_cast<double>(WrinkleState::taut) * dV;
      }
      for (int a = 0; a < Kernel::nodes; ++a) {
        const auto node = static_cast<std::size_t>(batch.element(e)[a]);
        const double w = rule.points[q].N(a) * rule.points[q].N(a) * dV;
        sums.weight[node] += w;
        sums.fields.nodal_largest[node] += w * p.largest;
        sums.fields.nodal_smallest[node] += w * p.smallest;
      }
    }
    sums.fields.cell_largest.push_back(largest / total);
    sums.fields.cell_smallest.push_back(smallest / total);
    largest_axis.append_to(sums.fields.cell_largest_direction);
    smallest_axis.append_to(sums.fields.cell_smallest_direction);
    sums.fields.cell_tension.push_back(0);
    sums.fields.cell_wrinkle_state.push_back(state / total);
    if constexpr (is_membrane<Kernel>) sums.area += total;
  }
}

void add(const Batch<Line>& batch, const Model& model, std::span<const double> u, double length, Sums& sums) {
  for (std::size_t e = 0; e < batch.count(); ++e) {
    const auto x = positions<Line>(model, u, batch.element(e));
    const double tension = Line::tension(at_length(batch.reference[e], length), batch.material, x);
    AxisMean axis;
    axis.add(x.col(1) - x.col(0), 1);
    axis.append_to(sums.fields.cell_largest_direction);
    sums.fields.cell_smallest_direction.insert(sums.fields.cell_smallest_direction.end(), 3, 0.0);
    sums.fields.cell_largest.push_back(0);
    sums.fields.cell_smallest.push_back(0);
    sums.fields.cell_tension.push_back(tension);
    sums.fields.max_tension = std::max(sums.fields.max_tension, tension);
    const bool slack = batch.material.tension_only && tension <= 0;
    sums.fields.cell_wrinkle_state.push_back(
        static_cast<double>(slack ? WrinkleState::slack : WrinkleState::taut));
    if (!batch.material.tension_only) continue;
    sums.cables += 1;
    if (slack) sums.slack += 1;
  }
}

} // namespace

StressFields stress_fields(const Model& model, std::span<const double> u, double time) {
  const std::vector<double> lengths = length_factors(model, time);
  Sums sums;
  const std::size_t n = model.node_count();
  sums.weight.assign(n, 0);
  sums.fields.nodal_largest.assign(n, 0);
  sums.fields.nodal_smallest.assign(n, 0);
  for (std::size_t k = 0; k < model.batches.size(); ++k)
    std::visit([&](const auto& batch) { add(batch, model, u, lengths[k], sums); }, model.batches[k]);
  for (std::size_t i = 0; i < n; ++i) {
    if (!(sums.weight[i] > 0)) continue;
    sums.fields.nodal_largest[i] /= sums.weight[i];
    sums.fields.nodal_smallest[i] /= sums.weight[i];
  }
  if (sums.max_stress >= sums.min_stress) {
    sums.fields.max_stress = sums.max_stress;
    sums.fields.min_stress = sums.min_stress;
  }
  if (sums.area > 0) sums.fields.wrinkled_fraction = sums.wrinkled_area / sums.area;
  if (sums.cables > 0)
    sums.fields.slack_fraction = static_cast<double>(sums.slack) / static_cast<double>(sums.cables);
  return std::move(sums.fields);
}

} // namespace drogue::structure
