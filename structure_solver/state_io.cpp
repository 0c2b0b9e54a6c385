// SPDX-License-Identifier: GPL-3.0-or-later
#include "structure_solver/state_io.hpp"

#include "common/io/state_file.hpp"

namespace drogue::structure {
namespace {

Result<std::vector<double>> take(const std::filesystem::path& file, const io::State& state,
                                 const Model& model, const char* name) {
  const io::StateArray* array = state.find(name);
  if (!array) return config_error("{}: the state has no array \"{}\"", file.string(), name);
  if (array->shape != std::vector<std::uint64_t>{model.node_count(), 3})
    return config_error("{}: array \"{}\" does not have shape {{{}, 3}}, one row a node", file.string(), name,
                        model.node_count());
  return array->values;
}

} // namespace

Result<void> save_state(const std::filesystem::path& file, const Model& model, const State& state) {
  io::State out{"structure", model.mesh_hash, state.time, state.step, {}};
  const std::vector<std::uint64_t> shape{model.node_count(), 3};
  out.add("displacement", shape, state.u);
  out.add("velocity", shape, state.v);
  out.add("acceleration", shape, state.a);
  if (!state.interface_force.empty()) out.add("interface_force", shape, state.interface_force);
  const EnergyLedger& l = state.ledger;
  if (l.start) out.add("energy", {5}, {*l.start, l.external, l.support, l.actuator, l.damping});
  out.add("halvings", {1}, {static_cast<double>(state.halvings)});
  return io::write_state(file, out);
}

Result<State> read_state(const std::filesystem::path& file, const Model& model) {
  const auto in = io::read_state(file);
  if (!in) return in.error();
  if (in->kind != "structure")
    return config_error("{}: holds a state of kind \"{}\"; one of kind \"structure\" is needed",
                        file.string(), in->kind);
  if (in->mesh_hash != model.mesh_hash)
    return config_error("{}: the state belongs to another mesh (hash {}; this mesh has {})", file.string(),
                        in->mesh_hash, model.mesh_hash);
  State state;
  state.time = in->time;
  state.step = in->step;
  struct Field {
    const char* name;
    std::vector<double>& values;
  };
  for (const Field& field :
       {Field{"displacement", state.u}, Field{"velocity", state.v}, Field{"acceleration", state.a}}) {
    auto values = take(file, *in, model, field.name);
    if (!values) return values.error();
    field.values = std::move(*values);
  }
  if (in->find("interface_force")) {
    auto force = take(file, *in, model, "interface_force");
    if (!force) return force.error();
    state.interface_force = std::move(*force);
  }
  if (const io::StateArray* energy = in->find("energy"); energy && energy->values.size() == 5) {
    const std::vector<double>& e = energy->values;
    state.ledger = {e[0], e[1], e[2], e[3], e[4]};
  }
  if (const io::StateArray* halvings = in->find("halvings"); halvings && halvings->values.size() == 1)
    state.halvings = static_cast<int>(halvings->values[0]);
  return state;
}

} // namespace drogue::structure
