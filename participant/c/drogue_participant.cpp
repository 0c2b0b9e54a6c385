// SPDX-License-Identifier: GPL-3.0-or-later
#include "participant/c/drogue_participant.h"

#include <cstdio>
#include <span>
#include <string>
#include <string_view>

#include "participant/cpp/participant.hpp"

using namespace drogue;

struct drogue_call {
  const participant::Fields* inputs = nullptr;
  participant::Fields* outputs = nullptr;
  /// {outputs of the contract}: name and shape.
  std::map<std::string, std::vector<std::uint64_t>, std::less<>> shapes;
  std::string trouble;
};

namespace {

std::string text(const char* s) {
  return s ? s : "";
}

std::vector<v1::FieldContract> contract(std::span<const drogue_field> fields) {
  std::vector<v1::FieldContract> entries;
  for (const drogue_field& f : fields)
    entries.push_back(participant::field(
        text(f.name), static_cast<v1::FieldContract::Quantity>(f.quantity),
        static_cast<v1::FieldContract::Location>(f.location), static_cast<std::uint32_t>(f.components),
        static_cast<v1::FieldContract::TimeLevel>(f.time_level), f.optional != 0));
  return entries;
}

template <class T>
std::vector<T> copied(const T* values, std::size_t count) {
  return values ? std::vector<T>(values, values + count) : std::vector<T>();
}

/// A drogue_solver as the C++ SDK wants it.
class CSolver : public participant::Solver {
 public:
  explicit CSolver(const drogue_solver& solver) : c_(solver) {}

  participant::Description describe() override {
    participant::Description d;
    d.software = text(c_.software);
    d.can_rollback = c_.can_rollback != 0;
    d.can_checkpoint = c_.can_checkpoint != 0;
    d.variable_step = c_.variable_step != 0;
    d.inputs = contract({c_.inputs, c_.input_count});
    d.outputs = contract({c_.outputs, c_.output_count});
    return d;
  }
  Result<void> configure(const participant::RunInfo& run) override {
    const std::string directory = run.directory.string();
    const drogue_run r{directory.c_str(), run.start_time, run.time_step, run.resume ? 1 : 0};
    return call("configure", c_.configure, &r);
  }
  Result<participant::InterfaceMesh> initialize() override {
    drogue_interface given{};
    DROGUE_TRY(call("initialize", c_.initialize, &given));
    return interface_of(given);
  }
  Result<void> begin_step(const participant::StepInfo& step) override {
    const drogue_step s{step.step, step.attempt, step.time, step.time_step};
    return call("begin_step", c_.begin_step, &s);
  }
  Result<participant::IterationReport> iterate(const participant::Fields& inputs,
                                               participant::Fields& outputs) override {
    drogue_call call{&inputs, &outputs, shapes_, {}};
    drogue_report report{0, 0, 1, 0};
    const int status = c_.iterate(c_.user, &call, &report);
    if (status != DROGUE_OK) return error("iterate", status, call);
    return participant::IterationReport{report.inner_iterations, report.inner_residual, report.converged != 0,
                                        report.fixed_iterations != 0};
  }
  Result<void> commit(bool write_output) override { return call("commit", c_.commit, write_output ? 1 : 0); }
  Result<void> rollback() override { return call("rollback", c_.rollback); }
  Result<void> checkpoint(const std::filesystem::path& directory) override {
    return call("checkpoint", c_.checkpoint, directory.c_str());
  }
  Result<void> restore(const std::filesystem::path& directory) override {
    return call("restore", c_.restore, directory.c_str());
  }

 private:
  template <class Function, class... Arguments>
  Result<void> call(const char* what, Function function, Arguments... arguments) {
    if (!function) return {};
    drogue_call call;
    const int status = function(c_.user, arguments..., &call);
    return status == DROGUE_OK ? Result<void>() : error(what, status, call);
  }

  static Error error(const char* what, int status, const drogue_call& call) {
    const std::string why =
        call.trouble.empty() ? fmt::format("{} failed with status {}", what, status) : call.trouble;
    if (status == DROGUE_CONFIG) return {ErrorKind::config, why};
    if (status == DROGUE_NUMERICAL) return {ErrorKind::numerical, why};
    if (status == DROGUE_RETRY) return {ErrorKind::numerical, why, true};
    return {ErrorKind::internal, why};
  }

  Result<participant::InterfaceMesh> interface_of(const drogue_interface& given) {
    participant::InterfaceMesh mesh;
    const std::size_t n = given.node_count;
    if (n == 0 || !given.points) return config_error("initialize gave an interface without points");
    mesh.points = copied(given.points, 3 * n);
    mesh.reference = copied(given.reference, 3 * n);
    mesh.material = copied(given.material, 3 * n);
    mesh.velocity = copied(given.velocity, 3 * n);
    for (std::size_t b = 0; b < given.block_count; ++b) {
      const drogue_elements& block = given.blocks[b];
      if (block.kind < 0 || block.kind >= static_cast<int>(participant::element_arrays.size()))
        return config_error("initialize gave elements of the unknown kind {}", block.kind);
      const auto& kind = participant::element_arrays[static_cast<std::size_t>(block.kind)];
      std::vector<std::int64_t>& all = mesh.*kind.elements;
      const auto own = copied(block.nodes, block.count * kind.nodes);
      all.insert(all.end(), own.begin(), own.end());
    }
    mesh.mesh_nodes = copied(given.mesh_nodes, n);
    mesh.mesh_node_count = given.mesh_node_count;
    mesh.mesh_hash = text(given.mesh_hash);
    for (std::size_t i = 0; i < c_.output_count; ++i) {
      const drogue_field& f = c_.outputs[i];
      const std::uint64_t nodes = f.location == DROGUE_INTERFACE_NODES ? n
                                  : f.location == DROGUE_MESH_NODES    ? mesh.mesh_node_count
                                                                       : 1;
      shapes_[text(f.name)] = {nodes, static_cast<std::uint64_t>(f.components)};
    }
    return mesh;
  }

  const drogue_solver& c_;
  std::map<std::string, std::vector<std::uint64_t>, std::less<>> shapes_;
};

} // namespace

int drogue_serve(const drogue_solver* solver, const char* endpoint) {
  if (!endpoint) {
    std::fprintf(stderr, "drogue_serve: no endpoint; the coupler gives it as --connect ENDPOINT\n");
    return DROGUE_CONFIG;
  }
  try {
    CSolver adapter(*solver);
    const auto outcome = participant::serve(adapter, participant::serve_options_from_environment(endpoint));
    if (outcome) return DROGUE_OK;
    std::fprintf(stderr, "%s\n", outcome.error().message.c_str());
    return exit_status(outcome.error());
  } catch (const std::exception& e) { // no exception may reach a C caller
    std::fprintf(stderr, "drogue_serve: %s\n", e.what());
    return DROGUE_INTERNAL;
  }
}

const char* drogue_endpoint(int argc, char** argv) {
  for (int i = 1; i + 1 < argc; ++i)
    if (std::string_view(argv[i]) == "--connect") return argv[i + 1];
  return nullptr;
}

const double* drogue_input(const drogue_call* call, const char* name) {
  if (!call->inputs) return nullptr;
  const auto it = call->inputs->find(name);
  return it == call->inputs->end() ? nullptr : it->second.values.data();
}

double* drogue_output(drogue_call* call, const char* name) {
  const auto shape = call->shapes.find(std::string_view(name));
  if (!call->outputs || shape == call->shapes.end()) return nullptr;
  participant::FloatArray& array = (*call->outputs)[name];
  if (array.values.empty()) {
    array.shape = shape->second;
    array.values.assign(array.shape[0] * array.shape[1], 0.0);
  }
  return array.values.data();
}

void drogue_explain(drogue_call* call, const char* text) {
  call->trouble = text;
}

void drogue_progress(const char* phase, std::uint32_t inner_iteration, double inner_residual) {
  participant::report_progress(phase, inner_iteration, inner_residual);
}
