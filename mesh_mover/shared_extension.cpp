// SPDX-License-Identifier: GPL-3.0-or-later
#include "mesh_mover/shared_extension.hpp"

#include <map>
#include <type_traits>
#include <utility>

#include "common/la_krylov/session.hpp"

namespace drogue::mesh_mover {
namespace {

enum class Task : std::uint64_t { make, prepare, extend, release, stop };

struct Order {
  Task task = Task::stop;
  std::uint64_t number = 0; ///< of the extension
};

template <class T>
void broadcast(T& value) {
  static_assert(std::is_trivially_copyable_v<T>);
  la::broadcast_passively(&value, sizeof(T));
}

template <class T>
void broadcast(std::vector<T>& values) {
  std::uint64_t size = values.size();
  broadcast(size);
  values.resize(size);
  la::broadcast_passively(values.data(), size * sizeof(T));
}

void broadcast(ExtensionInput& input) {
  broadcast(input.method);
  broadcast(input.cells.dimension);
  broadcast(input.cells.nodes);
  broadcast(input.given);
  broadcast(input.factors);
  std::uint64_t bodies = input.bodies.size();
  broadcast(bodies);
  input.bodies.resize(bodies);
  for (auto& body : input.bodies) broadcast(body);
  broadcast(input.numbers);
}

void order(Task task, std::uint64_t number) {
  Order given{task, number};
  broadcast(given);
}

} // namespace

SharedExtension::SharedExtension(ExtensionInput input) {
  static std::uint64_t made = 0;
  number_ = ++made;
  order(Task::make, number_);
  broadcast(input);
  own_ = make_extension(std::move(input), true);
}

SharedExtension::~SharedExtension() {
  order(Task::release, number_);
}

Result<void> SharedExtension::prepare(std::span<const double> points) {
  order(Task::prepare, number_);
  std::vector<double> sent(points.begin(), points.end());
  broadcast(sent);
  return own_->prepare(points);
}

Result<SolveOutcome> SharedExtension::extend(std::span<double> u, std::span<const double> increment) {
  order(Task::extend, number_);
  std::vector<double> sent(u.begin(), u.end());
  broadcast(sent);
  sent.assign(increment.begin(), increment.end());
  broadcast(sent);
  return own_->extend(u, increment);
}

void serve_extensions() {
  std::map<std::uint64_t, std::unique_ptr<Extension>> extensions;
  std::vector<double> points, u, increment;
  for (Order order;;) {
    broadcast(order);
    switch (order.task) {
    case Task::make: {
      ExtensionInput input;
      broadcast(input);
      extensions[order.number] = make_extension(std::move(input), true);
      break;
    }
    case Task::prepare:
      broadcast(points);
      (void)extensions.at(order.number)->prepare(points); // what it says is the same on the first rank
      break;
    case Task::extend:
      broadcast(u);
      broadcast(increment);
      (void)extensions.at(order.number)->extend(u, increment);
      break;
    case Task::release:
      extensions.erase(order.number);
      break;
    case Task::stop:
      return;
    }
  }
}

void stop_other_ranks() {
  if (la::rank_count() > 1) order(Task::stop, 0);
}

} // namespace drogue::mesh_mover
