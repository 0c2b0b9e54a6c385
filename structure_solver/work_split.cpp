// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/work_split.hpp"

#include <algorithm>
#include <numeric>

namespace drogue::structure {
namespace {

template <class Batch>
constexpr int nodes_per_element(const Batch&) {
  if constexpr (requires { typename Batch::KernelType; })
    return Batch::KernelType::nodes;
  else
    return ElementTraits<Batch::kind>::nodes;
}

/// A tangent of n x n blocks at some n points costs like n^3.
std::vector<double> work_of_nodes(const Model& model) {
  std::vector<double> work(model.node_count(), 1.0);
  for (const AnyBatch& any : model.batches)
    std::visit(
        [&](const auto& batch) {
          const double n = nodes_per_element(batch);
          for (const std::int32_t node : batch.nodes) work[static_cast<std::size_t>(node)] += n * n;
        },
        any);
  return work;
}

/// The direction in which the reference configuration is longest.
std::size_t longest_direction(const std::vector<double>& points) {
  std::size_t longest = 0;
  double length = -1;
  for (std::size_t c = 0; c < 3; ++c) {
    double low = points[c], high = points[c];
    for (std::size_t i = c; i < points.size(); i += 3) {
      low = std::min(low, points[i]);
      high = std::max(high, points[i]);
    }
    if (high - low > length) {
      length = high - low;
      longest = c;
    }
  }
  return longest;
}

void share_nodes(const Model& model, int workers, WorkSplit& split) {
  const std::vector<double>& points = model.mesh.points;
  split.owner.assign(model.node_count(), 0);
  split.nodes.resize(static_cast<std::size_t>(workers));
  if (points.empty()) return;
  std::vector<std::int32_t> order(model.node_count());
  std::iota(order.begin(), order.end(), 0);
  const std::size_t c = longest_direction(points);
  std::stable_sort(order.begin(), order.end(), [&](std::int32_t a, std::int32_t b) {
    return points[3 * static_cast<std::size_t>(a) + c] < points[3 * static_cast<std::size_t>(b) + c];
  });
  const std::vector<double> work = work_of_nodes(model);
  const double share = std::accumulate(work.begin(), work.end(), 0.0) / workers;
  double done = 0;
  for (const std::int32_t node : order) {
    const auto i = static_cast<std::size_t>(node);
    split.owner[i] = std::min(workers - 1, static_cast<int>((done + 0.5 * work[i]) / share));
    done += work[i];
  }
  for (std::size_t i = 0; i < split.owner.size(); ++i)
    split.nodes[static_cast<std::size_t>(split.owner[i])].push_back(static_cast<std::int32_t>(i));
}

/// Elements of a batch that touch a node of each worker.
template <class Batches>
std::vector<std::vector<WorkSplit::Elements>>
share_elements(const Batches& batches, const std::vector<std::int32_t>& owner, std::size_t workers) {
  std::vector<std::vector<WorkSplit::Elements>> shares(workers,
                                                       std::vector<WorkSplit::Elements>(batches.size()));
  const auto share = [&](const auto& batch, std::size_t index) {
    const auto n = static_cast<std::size_t>(nodes_per_element(batch));
    for (std::size_t e = 0; e < batch.count(); ++e)
      for (std::size_t a = 0; a < n; ++a) {
        const auto worker = static_cast<std::size_t>(owner[static_cast<std::size_t>(batch.nodes[e * n + a])]);
        WorkSplit::Elements& own = shares[worker][index];
        const auto element = static_cast<std::int32_t>(e);
        if (own.empty() || own.back() != element) own.push_back(element);
      }
  };
  for (std::size_t k = 0; k < batches.size(); ++k)
    std::visit([&](const auto& batch) { share(batch, k); }, batches[k]);
  return shares;
}

} // namespace

WorkSplit split_work(const Model& model, int workers) {
  WorkSplit split;
  share_nodes(model, workers, split);
  split.elements = share_elements(model.batches, split.owner, split.nodes.size());
  split.pressure_elements = share_elements(model.pressure_batches, split.owner, split.nodes.size());
  return split;
}

} // namespace drogue::structure
