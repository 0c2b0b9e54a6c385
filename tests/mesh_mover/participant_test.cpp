// SPDX-License-Identifier: GPL-3.0-or-later
// mesh_mover as a participant, and its configs.
#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include "common/mesh/msh.hpp"
#include "mesh_mover/mesh_participant.hpp"
#include "mesh_mover/standalone.hpp"
#include "tests/mesh_mover/body_in_box.hpp"
#include "tests/support/signalled.hpp"

namespace drogue::mesh_mover {
namespace {

namespace fs = std::filesystem;

constexpr const char* config_text = R"(mesh: "box.msh"
boundary { name: "body" displacement { x: "0.1*t" } }
boundary { name: "x0" translated {} }
boundary { name: "x1" translated {} }
boundary { name: "y0" translated {} }
boundary { name: "y1" translated {} }
boundary { name: "z0" translated {} }
boundary { name: "z1" translated {} }
interface: "body"
tolerance: 1e-6
step: 0.5
steps: 3
)";

class MeshMoverRun : public test::BodyInBox {
 protected:
  MeshMoverRun() : BodyInBox(1.8) {}

  Result<Case> load(const std::string& text, Role role = Role::alone) { return load_config(text, role); }
  Case valid_case() { return BodyInBox::valid_case(config_text); }
  /// The message of a config in which `from` is replaced by `to`.
  std::string error_of(std::string text, const std::string& from, const std::string& to,
                       Role role = Role::alone) {
    text.replace(text.find(from), from.size(), to);
    const auto input = load(text, role);
    EXPECT_FALSE(input.ok());
    return input.ok() ? "" : input.error().message;
  }
};

/// A participant that was initialised, with the sizes of its interface.
struct Ready {
  MeshParticipant solver;
  participant::InterfaceMesh interface;

  Ready(Case input, const fs::path& folder) : solver(std::move(input)) {
    EXPECT_TRUE(solver.configure({folder, 0, 0.1}).ok());
    auto mesh = solver.initialize();
    EXPECT_TRUE(mesh.ok());
    interface = std::move(*mesh);
  }
  Result<participant::IterationReport> iterate(double amplitude, participant::Fields& outputs) {
    participant::Fields inputs;
    participant::FloatArray d{{interface.points.size() / 3, 3}, interface.points};
    for (std::size_t i = 0; i < d.values.size(); ++i)
      d.values[i] = amplitude * std::sin(9 * d.values[i] + static_cast<double>(i % 3));
    inputs["displacement"] = std::move(d);
    inputs["translation"] = {{1, 3}, {0.1 * amplitude, 0, 0.3 * amplitude}};
    return solver.iterate(inputs, outputs);
  }
  std::vector<double> displacement_after(double amplitude) {
    participant::Fields outputs;
    const auto report = iterate(amplitude, outputs);
    EXPECT_TRUE(report.ok()) << report.error().message;
    return outputs["mesh_displacement"].values;
  }
  void begin(std::uint64_t step) {
    EXPECT_TRUE(solver.begin_step({step, 1, 0.1 * static_cast<double>(step - 1), 0.1}).ok());
  }
  std::vector<double> whole_step(std::uint64_t step, double amplitude) {
    begin(step);
    displacement_after(0.7 * amplitude);
    auto u = displacement_after(amplitude);
    EXPECT_TRUE(solver.commit(false).ok());
    return u;
  }
};

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), 8 * a.size()) == 0;
}

TEST_F(MeshMoverRun, ShowsItsInterface) {
  const Ready ready(valid_case(), folder_);
  const auto mesh = mesh::read_msh(folder_ / "box.msh");
  ASSERT_TRUE(mesh.ok());
  const auto& interface = ready.interface;
  EXPECT_EQ(interface.mesh_hash, mesh::hash(*mesh));
  EXPECT_EQ(interface.mesh_node_count, static_cast<std::uint64_t>(mesh->node_count()));
  const auto nodes = mesh->nodes_of("body");
  ASSERT_EQ(interface.mesh_nodes.size(), nodes.size());
  const auto* block = mesh->blocks_of("body").front();
  ASSERT_EQ(interface.triangles.size(), block->nodes.size());
  for (std::size_t k = 0; k < block->nodes.size(); ++k)
    EXPECT_EQ(interface.mesh_nodes[static_cast<std::size_t>(interface.triangles[k])], block->nodes[k]);
  ASSERT_EQ(interface.material.size(), interface.points.size());
  for (std::size_t k = 0; k < interface.points.size(); ++k)
    EXPECT_EQ(interface.material[k], 10 * interface.points[k]);
}

TEST_F(MeshMoverRun, FollowsTheInterfaceAndTheTranslation) {
  Ready ready(valid_case(), folder_);
  ready.begin(1);
  participant::Fields outputs;
  ASSERT_TRUE(ready.iterate(0.02, outputs).ok());
  const auto& u = outputs["mesh_displacement"].values;
  for (std::size_t k = 0; k < ready.interface.mesh_nodes.size(); ++k) {
    const auto node = 3 * static_cast<std::size_t>(ready.interface.mesh_nodes[k]);
    for (std::size_t c = 0; c < 3; ++c)
      EXPECT_EQ(u[node + c], 0.02 * std::sin(9 * ready.interface.points[3 * k + c] + static_cast<double>(c)));
  }
  const auto mesh = mesh::read_msh(folder_ / "box.msh");
  for (const std::int32_t node : mesh->nodes_of("z1"))
    EXPECT_EQ(u[3 * static_cast<std::size_t>(node) + 2], 0.3 * 0.02);
  const auto& quality = outputs["quality"];
  EXPECT_EQ(quality.shape, (std::vector<std::uint64_t>{1, 3}));
  EXPECT_GT(quality.values[0], 0.1);
  EXPECT_LT(quality.values[0], 1);
  EXPECT_LE(quality.values[1], quality.values[2]);
}

TEST_F(MeshMoverRun, RepeatsItselfToTheBitAndRollsBackExactly) {
  Ready once(valid_case(), folder_);
  Ready again(valid_case(), folder_);
  EXPECT_TRUE(same_bits(once.whole_step(1, 0.02), again.whole_step(1, 0.02)));
  // One of them tries something else, partly refused, and rolls back.
  again.begin(2);
  again.displacement_after(0.05);
  participant::Fields outputs;
  EXPECT_FALSE(again.iterate(5, outputs).ok());
  EXPECT_TRUE(again.solver.rollback().ok());
  EXPECT_TRUE(same_bits(once.whole_step(2, 0.03), again.whole_step(2, 0.03)));
  EXPECT_TRUE(same_bits(once.whole_step(3, 0.01), again.whole_step(3, 0.01)));
}

TEST_F(MeshMoverRun, ContinuesFromACheckpointToTheBit) {
  for (const auto increment : {Increment::from_last_step, Increment::from_initial}) {
    Case input = valid_case();
    input.settings.increment = increment;
    Ready whole(input, folder_);
    whole.whole_step(1, 0.02);
    whole.whole_step(2, 0.03);
    ASSERT_TRUE(whole.solver.checkpoint(folder_).ok());
    Ready resumed(input, folder_);
    ASSERT_TRUE(resumed.solver.restore(folder_).ok());
    EXPECT_TRUE(same_bits(whole.whole_step(3, 0.035), resumed.whole_step(3, 0.035)));
  }
}

TEST_F(MeshMoverRun, RefusesTheStateOfAnotherMesh) {
  Ready ready(valid_case(), folder_);
  ASSERT_TRUE(ready.solver.checkpoint(folder_).ok());
  auto state = io::read_state(folder_ / "mesh_mover.state");
  ASSERT_TRUE(state.ok());
  state->mesh_hash = "another";
  ASSERT_TRUE(io::write_state(folder_ / "mesh_mover.state", *state).ok());
  const auto refused = ready.solver.restore(folder_);
  ASSERT_FALSE(refused.ok());
  EXPECT_NE(refused.error().message.find("another"), std::string::npos) << refused.error().message;
}

TEST_F(MeshMoverRun, NeedsAnInterfaceWhenCoupled) {
  EXPECT_NE(error_of(config_text, "interface: \"body\"", "", Role::participant)
                .find("a participant needs interface"),
            std::string::npos);
}

TEST_F(MeshMoverRun, RunsAloneAndWritesResults) {
  const auto done = run_standalone(valid_case());
  ASSERT_TRUE(done.ok()) << done.error().message;
  std::ifstream csv(folder_ / "results" / "mesh.csv");
  std::vector<std::string> lines;
  for (std::string line; std::getline(csv, line);) lines.push_back(line);
  ASSERT_EQ(lines.size(), 5U); // header, start, three steps
  EXPECT_EQ(lines[0].substr(0, 10), "step,time,");
  EXPECT_EQ(lines[4].substr(0, 6), "3,1.5,");
  EXPECT_TRUE(fs::exists(folder_ / "results" / "mesh.pvd"));
  EXPECT_TRUE(fs::exists(folder_ / "results" / "mesh_000003.vtu"));
}

TEST_F(MeshMoverRun, AFailedStepIsNamed) {
  Case input = valid_case();
  input.settings.step = 20;
  const auto failed = run_standalone(std::move(input));
  ASSERT_FALSE(failed.ok());
  EXPECT_EQ(exit_status(failed.error()), 3);
  EXPECT_EQ(failed.error().message.substr(0, 16), "step 1 (time 20)") << failed.error().message;
}

TEST_F(MeshMoverRun, CheckNamesEveryError) {
  const std::string unknown = error_of(config_text, "\"z1\" translated", "\"z\" translated");
  EXPECT_NE(unknown.find("mesh.textproto:8:"), std::string::npos) << unknown;
  EXPECT_NE(unknown.find("did you mean"), std::string::npos) << unknown;
  EXPECT_NE(unknown.find("boundary \"z1\" of box.msh is not mentioned"), std::string::npos) << unknown;
  const std::string twice = error_of(config_text, "\"y1\" translated", "\"y0\" translated");
  EXPECT_NE(twice.find("mesh.textproto:6:"), std::string::npos) << twice;
  EXPECT_NE(twice.find("boundary \"y0\" is given twice"), std::string::npos) << twice;
  EXPECT_NE(error_of(config_text, "\"x0\" translated {}", "\"x0\"").find("needs a condition"),
            std::string::npos);
  EXPECT_NE(error_of(config_text, "\"x0\" translated {}", "\"x0\" sliding { normal: \"w\" }")
                .find("it must be \"x\""),
            std::string::npos);
  EXPECT_NE(error_of(config_text, "interface: \"body\"", "interface: \"bodi\"").find("did you mean \"body\""),
            std::string::npos);
  EXPECT_NE(error_of(config_text, "interface: \"body\"", "interface: \"x0\"")
                .find("must be a boundary with a displacement"),
            std::string::npos);
  EXPECT_NE(error_of(config_text, "\"box.msh\"", "\"sphere.msh\"").find("sphere.msh"), std::string::npos);
  EXPECT_NE(error_of(config_text, "0.1*t", "0.1*q").find("mesh.textproto:2:"), std::string::npos);
}

TEST_F(MeshMoverRun, ASignalEndsTheRunAfterTheStep) {
  std::string text = config_text;
  text.replace(text.find("0.1*t"), 5, "0.1*sin(t)");
  text.replace(text.find("steps: 3"), 8,
               "steps: 1000000 output { directory: \"results\" field_interval: 1000000 }");
  std::ofstream(folder_ / "mesh.textproto") << text;
  const std::string command = "cd '" + folder_.string() + "' && " +
                              drogue::test::signalled("TERM", "step 1 ") +
                              "'" DROGUE_BIN_DIR "/mesh_mover' run mesh.textproto > log 2>&1";
  const int status = std::system(command.c_str());
  std::stringstream log;
  log << std::ifstream(folder_ / "log").rdbuf();
  EXPECT_EQ(WEXITSTATUS(status), 5) << log.str();
  EXPECT_NE(log.str().find("interrupted after step "), std::string::npos) << log.str();
  const auto fields =
      std::count_if(fs::directory_iterator(folder_ / "results"), fs::directory_iterator(),
                    [](const fs::directory_entry& file) { return file.path().extension() == ".vtu"; });
  EXPECT_EQ(fields, 2); // the start and the last step
}

} // namespace
} // namespace drogue::mesh_mover
