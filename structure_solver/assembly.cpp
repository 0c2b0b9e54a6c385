// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/assembly.hpp"

#include <algorithm>
#include <utility>

namespace drogue::structure {
namespace {

using NodePair = std::pair<std::int32_t, std::int32_t>;

void add_pairs(const std::int32_t* nodes, int count, std::vector<NodePair>& pairs) {
  for (int a = 0; a < count; ++a)
    for (int b = a + 1; b < count; ++b) pairs.emplace_back(nodes[a], nodes[b]);
}

std::vector<NodePair> coupled_nodes(const Model& model) {
  std::vector<NodePair> pairs;
  for (const AnyBatch& any : model.batches)
    std::visit(
        [&](const auto& batch) {
          using Kernel = typename std::decay_t<decltype(batch)>::KernelType;
          for (std::size_t e = 0; e < batch.count(); ++e) add_pairs(batch.element(e), Kernel::nodes, pairs);
        },
        any);
  for (const AnyPressureBatch& any : model.pressure_batches)
    std::visit(
        [&](const auto& batch) {
          constexpr int n = ElementTraits<std::decay_t<decltype(batch)>::kind>::nodes;
          for (std::size_t e = 0; e < batch.count(); ++e) add_pairs(&batch.nodes[e * n], n, pairs);
        },
        any);
  return pairs;
}

std::vector<std::int32_t> slots(const BlockMatrix& matrix, const std::vector<std::int32_t>& nodes,
                                int per_element) {
  std::vector<std::int32_t> result;
  const auto n = static_cast<std::size_t>(per_element);
  for (std::size_t e = 0; e < nodes.size() / n; ++e)
    for (std::size_t b = 0; b < n; ++b)
      for (std::size_t a = 0; a < n; ++a) result.push_back(matrix.slot(nodes[e * n + a], nodes[e * n + b]));
  return result;
}

template <int Nodes>
typename Response<Nodes>::Positions current_positions(const std::vector<double>& X, std::span<const double> u,
                                                      const std::int32_t* nodes) noexcept {
  typename Response<Nodes>::Positions x;
  for (int a = 0; a < Nodes; ++a) {
    const std::size_t i = 3 * static_cast<std::size_t>(nodes[a]);
    for (std::size_t c = 0; c < 3; ++c) x(static_cast<int>(c), a) = X[i + c] + u[i + c];
  }
  return x;
}

/// A thread for fewer nodes than this costs more in waking it up than it saves.
constexpr std::size_t nodes_per_thread = 1000;

int threads_for(const Model& model) {
  const auto worthwhile = static_cast<int>(std::min<std::size_t>(model.node_count() / nodes_per_thread, 256));
  return std::clamp(worthwhile, 1, default_threads());
}

} // namespace

Assembler::Assembler(const Model& model, int threads)
    : model_(model),
      tangent_(model.mesh.node_count(), coupled_nodes(model), model.held),
      pool_(threads > 0 ? threads : threads_for(model)),
      split_(split_work(model, pool_.size())) {
  for (const AnyBatch& any : model.batches)
    std::visit(
        [&](const auto& batch) {
          energy_.emplace_back(batch.count(), 0.0);
          batch_slots_.push_back(
              slots(tangent_, batch.nodes, std::decay_t<decltype(batch)>::KernelType::nodes));
        },
        any);
  for (const AnyPressureBatch& any : model.pressure_batches)
    std::visit(
        [&](const auto& batch) {
          pressure_slots_.push_back(
              slots(tangent_, batch.nodes, ElementTraits<std::decay_t<decltype(batch)>::kind>::nodes));
        },
        any);
}

double Assembler::assemble(const Request& request, std::span<double> residual) {
  pool_.run([&](int worker) {
    for (const std::int32_t node : split_.nodes[static_cast<std::size_t>(worker)]) {
      if (request.tangent) tangent_.set_zero(node);
      const std::size_t i = 3 * static_cast<std::size_t>(node);
      for (std::size_t c = 0; c < 3; ++c) residual[i + c] = -request.loads.force[i + c];
    }
    add_elements(worker, request, residual);
    add_pressure(worker, request, residual);
  });
  double energy = 0;
  for (const std::vector<double>& batch : energy_)
    for (const double of_element : batch) energy += of_element;
  return energy;
}

void Assembler::add_block(std::int32_t row, std::int32_t column, const Eigen::Matrix3d& block) noexcept {
  const BlockMatrix::BlockColumn at = tangent_.column(column);
  const std::int32_t slot = tangent_.slot(row, column);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) at.value[c * at.height + 3 * slot + r] += block(r, c);
}

void Assembler::external_force(std::span<const double> displacement, const LoadValues& loads,
                               std::span<double> force) {
  std::fill(force.begin(), force.end(), 0.0);
  const Request request{.displacement = {}, .load_displacement = displacement, .loads = loads};
  pool_.run([&](int worker) { add_pressure(worker, request, force); });
  for (std::size_t i = 0; i < force.size(); ++i) force[i] = loads.force[i] - force[i];
}

template <int Nodes>
void Assembler::scatter(int worker, const Response<Nodes>& response, const std::int32_t* nodes,
                        std::span<double> residual) const noexcept {
  for (int a = 0; a < Nodes; ++a) {
    const auto node = static_cast<std::size_t>(nodes[a]);
    if (split_.owner[node] != worker) continue;
    for (int c = 0; c < 3; ++c) residual[3 * node + static_cast<std::size_t>(c)] += response.force(c, a);
  }
}

template <int Nodes>
void Assembler::scatter_tangent(int worker, const Response<Nodes>& response, const std::int32_t* nodes,
                                const std::int32_t* slot, double scale) noexcept {
  for (int b = 0; b < Nodes; ++b, slot += Nodes) {
    if (split_.owner[static_cast<std::size_t>(nodes[b])] != worker) continue;
    const BlockMatrix::BlockColumn column = tangent_.column(nodes[b]);
    for (int c = 0; c < 3; ++c) {
      double* value = column.value + c * column.height;
      const double* k = &response.tangent(0, 3 * b + c);
      for (int a = 0; a < Nodes; ++a)
        for (int r = 0; r < 3; ++r) value[3 * slot[a] + r] += scale * k[3 * a + r];
    }
  }
}

void Assembler::add_elements(int worker, const Request& request, std::span<double> residual) {
  const auto add = [&](const auto& batch, std::size_t k) {
    using Kernel = typename std::decay_t<decltype(batch)>::KernelType;
    constexpr int n = Kernel::nodes;
    const double length = request.loads.length_factor[k];
    Response<n> response;
    for (const std::int32_t element : split_.elements[static_cast<std::size_t>(worker)][k]) {
      const auto e = static_cast<std::size_t>(element);
      const std::int32_t* nodes = batch.element(e);
      const auto x = current_positions<n>(model_.mesh.points, request.displacement, nodes);
      Kernel::evaluate(at_length(batch.reference[e], length), batch.material, x, request.tangent, response);
      if (split_.owner[static_cast<std::size_t>(nodes[0])] == worker) energy_[k][e] = response.energy;
      scatter(worker, response, nodes, residual);
      if (request.tangent)
        scatter_tangent(worker, response, nodes, &batch_slots_[k][e * n * n], request.tangent_scale);
    }
  };
  for (std::size_t k = 0; k < model_.batches.size(); ++k)
    std::visit([&](const auto& batch) { add(batch, k); }, model_.batches[k]);
}

void Assembler::add_pressure(int worker, const Request& request, std::span<double> residual) {
  const bool stiffness = request.tangent && request.load_stiffness;
  const auto add = [&](const auto& batch, std::size_t k) {
    constexpr mesh::ElementKind kind = std::decay_t<decltype(batch)>::kind;
    constexpr int n = ElementTraits<kind>::nodes;
    const ElementRule<kind>& rule = element_rule<kind>();
    const std::vector<double>& pressure = request.loads.pressure[batch.load];
    Response<n> response;
    typename FollowerPressure<kind>::NodalPressure p;
    for (const std::int32_t element : split_.pressure_elements[static_cast<std::size_t>(worker)][k]) {
      const auto e = static_cast<std::size_t>(element);
      const std::int32_t* nodes = &batch.nodes[e * n];
      for (int a = 0; a < n; ++a) p(a) = pressure[static_cast<std::size_t>(nodes[a])];
      const auto x = current_positions<n>(model_.mesh.points, request.load_displacement, nodes);
      FollowerPressure<kind>::evaluate(rule, p, x, stiffness, response);
      scatter(worker, response, nodes, residual);
      if (stiffness)
        scatter_tangent(worker, response, nodes, &pressure_slots_[k][e * n * n], request.load_scale);
    }
  };
  for (std::size_t k = 0; k < model_.pressure_batches.size(); ++k)
    std::visit([&](const auto& batch) { add(batch, k); }, model_.pressure_batches[k]);
}

} // namespace drogue::structure
