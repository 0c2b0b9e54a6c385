// SPDX-License-Identifier: GPL-3.0-or-later
// The smallest structure in C++: a rigid unit square on a spring, m a + k d = f / A along z, released from
// rest at
// `--start`. Time: the trapezoidal rule.
//
//     spring --mass M --stiffness K --start D --connect ENDPOINT
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <string>

#include <participant/cpp/participant.hpp>

namespace {

using namespace drogue;
using namespace drogue::participant;
using C = v1::FieldContract;

struct Motion {
  double d = 0, v = 0, a = 0;
};

class Spring : public Solver {
 public:
  Spring(double mass, double stiffness, double start)
      : mass_(mass),
        stiffness_(stiffness),
        start_(start),
        n_{start, 0, -stiffness / mass * start},
        now_(n_) {}

  Description describe() override {
    Description d;
    d.software = "spring";
    d.can_checkpoint = true;
    d.inputs = {field("force", C::FORCE, C::INTERFACE_NODES, 3)};
    d.outputs = {field("displacement", C::DISPLACEMENT, C::INTERFACE_NODES, 3),
                 field("velocity", C::VELOCITY, C::INTERFACE_NODES, 3)};
    return d;
  }
  Result<void> configure(const RunInfo&) override { return {}; }
  Result<InterfaceMesh> initialize() override {
    InterfaceMesh mesh;
    mesh.points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
    mesh.quadrangles4 = {0, 1, 2, 3};
    mesh.mesh_node_count = 4;
    return mesh;
  }
  Result<void> begin_step(const StepInfo& step) override {
    dt_ = step.time_step;
    return {};
  }
  Result<IterationReport> iterate(const Fields& inputs, Fields& outputs) override {
    const auto& f = inputs.at("force").values;
    const double guess = n_.d + dt_ * n_.v + 0.25 * dt_ * dt_ * n_.a; // d = guess + dt^2/4 a
    now_.a = (f[2] + f[5] + f[8] + f[11] - stiffness_ * guess) / (mass_ + 0.25 * dt_ * dt_ * stiffness_);
    now_.d = guess + 0.25 * dt_ * dt_ * now_.a;
    now_.v = n_.v + 0.5 * dt_ * (n_.a + now_.a);
    outputs["displacement"] = everywhere(now_.d - start_); // since initialize
    outputs["velocity"] = everywhere(now_.v);
    return IterationReport{};
  }
  Result<void> commit(bool) override {
    n_ = now_;
    return {};
  }
  Result<void> rollback() override {
    now_ = n_;
    return {};
  }
  Result<void> checkpoint(const std::filesystem::path& directory) override {
    std::ofstream file(directory / "motion", std::ios::binary);
    file.write(reinterpret_cast<const char*>(&n_), sizeof n_);
    return file ? Result<void>() : internal_error("cannot write {}", (directory / "motion").string());
  }
  Result<void> restore(const std::filesystem::path& directory) override {
    std::ifstream file(directory / "motion", std::ios::binary);
    file.read(reinterpret_cast<char*>(&n_), sizeof n_);
    now_ = n_;
    return file ? Result<void>() : config_error("cannot read {}", (directory / "motion").string());
  }

 private:
  static FloatArray everywhere(double z) { return {{4, 3}, {0, 0, z, 0, 0, z, 0, 0, z, 0, 0, z}}; }
  double mass_, stiffness_, start_, dt_ = 0;
  Motion n_, now_;
};

} // namespace

int main(int argc, char** argv) {
  double mass = 1, stiffness = 1, start = 0;
  std::string endpoint;
  for (int i = 1; i + 1 < argc; i += 2) {
    const std::string name = argv[i];
    if (name == "--mass") mass = std::atof(argv[i + 1]);
    if (name == "--stiffness") stiffness = std::atof(argv[i + 1]);
    if (name == "--start") start = std::atof(argv[i + 1]);
    if (name == "--connect") endpoint = argv[i + 1];
  }
  Spring spring(mass, stiffness, start);
  const auto outcome = serve(spring, serve_options_from_environment(endpoint));
  if (!outcome) std::fprintf(stderr, "%s\n", outcome.error().message.c_str());
  return outcome ? 0 : exit_status(outcome.error());
}
