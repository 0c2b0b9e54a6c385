// SPDX-License-Identifier: GPL-3.0-or-later
// `coupler conform`: good participants pass, each broken one fails the promise it breaks.
#include <algorithm>
#include <regex>
#include <set>

#include "tests/support/checkpoint_runs.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;
using Words = std::vector<std::string>;

Words joined(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

struct Judged {
  int status = -1;
  std::string text, json;
  [[nodiscard]] std::set<std::string> with(const std::string& verdict) const {
    std::set<std::string> names;
    const std::regex entry("\"name\": \"([a-z_]+)\",[^\n]*\"verdict\": \"" + verdict + "\"");
    for (std::sregex_iterator it(json.begin(), json.end(), entry), end; it != end; ++it)
      names.insert((*it)[1]);
    return names;
  }
};

Judged conform(const fs::path& folder, const Words& options, const Words& command) {
  Judged j;
  j.status = run_coupler_with(
      folder, joined(joined({"conform", "--json", "report.json"}, options), joined({"--"}, command)));
  j.text = read_text(folder / "output.txt");
  j.json = read_text(folder / "report.json");
  return j;
}

TEST(Conform, TheOscillatorsKeepEveryPromise) {
  for (const std::string role : {"structure", "fluid", "mesh_mover"}) {
    const auto folder = fresh_folder(role);
    const Judged j =
        conform(folder, {}, {std::string(DROGUE_TEST_BIN_DIR) + "/oscillator_participant", role});
    EXPECT_EQ(j.status, 0) << j.text;
    EXPECT_EQ(j.with("pass").size(), 30u) << j.text;
    EXPECT_EQ(j.with("skip"), std::set<std::string>{"beats"}) << j.text;
    EXPECT_NE(j.json.find("\"conforms\": true"), std::string::npos) << j.json;
    EXPECT_NE(j.json.find("\"role\": \"" + role + "\""), std::string::npos)
        << "found by its fields: " << j.json;
    EXPECT_NE(j.text.find("30 passed, 0 failed, 1 do not apply, 0 not reached: it conforms"),
              std::string::npos)
        << j.text;
  }
}

TEST(Conform, WhatAParticipantCannotDoDoesNotApply) {
  const auto folder = fresh_folder("modest");
  const Judged j = conform(folder, {"--only", "rollback", "checkpoint", "restore", "hello"},
                           {std::string(DROGUE_TEST_BIN_DIR) + "/oscillator_participant", "structure",
                            "--checkpoints", "no", "--rolls-back", "no"});
  EXPECT_EQ(j.status, 0) << j.text;
  EXPECT_TRUE(j.with("skip").count("rollback") && j.with("skip").count("checkpoint")) << j.text;
  EXPECT_TRUE(j.with("pass").count("hello")) << j.text;
  EXPECT_NE(j.text.find("it says that it cannot roll back"), std::string::npos) << j.text;
}

TEST(Conform, AProgramThatDoesNotSpeakFailsHello) {
  const auto folder = fresh_folder("mute");
  const Judged j = conform(folder, {}, {"ls", "/no/such/folder"});
  EXPECT_EQ(j.status, 4);
  EXPECT_EQ(j.with("FAIL"), std::set<std::string>{"hello"}) << j.text;
  EXPECT_NE(j.text.find("exited with status 2"), std::string::npos) << j.text;
  EXPECT_EQ(conform(fresh_folder("none"), {}, {"no_such_program"}).status, 2);
}

/// A fault of broken_participant.py, the promise it breaks, and part of what the report says.
struct Fault {
  const char *fault, *promise, *detail;
};

class Broken : public testing::TestWithParam<Fault> {};

TEST_P(Broken, FailsThePromiseItBreaks) {
  const Fault f = GetParam();
  const auto folder = fresh_folder(f.fault);
  const Judged j =
      conform(folder, {"--as", "structure", "--deadline", "10", "--only", f.promise},
              {DROGUE_PYTHON, std::string(DROGUE_SOURCE_DIR) + "/tests/coupler/conform/broken_participant.py",
               f.fault});
  EXPECT_EQ(j.status, 4) << j.text;
  EXPECT_TRUE(j.with("FAIL").count(f.promise)) << j.text;
  EXPECT_NE(j.text.find(f.detail), std::string::npos) << j.text;
  for (const std::string& other : j.with("FAIL")) EXPECT_EQ(other, f.promise) << j.text;
}

INSTANTIATE_TEST_SUITE_P(
    Each, Broken,
    testing::Values(Fault{"hello", "hello", "nothing came for 10 s"},
                    Fault{"version", "version", "it speaks versions 2 to 2"},
                    Fault{"identity", "identity", "participant \"somebody\""},
                    Fault{"processes", "processes", "names no process"},
                    Fault{"contract", "contract", "\"displacement\" is declared as TRACTION"},
                    Fault{"no_velocity", "contract", "does not give \"velocity\""},
                    Fault{"interface", "initialize", "\"triangles\" names node 3 of 3"},
                    Fault{"shape", "iterate", "\"velocity\" has shape {2, 3}"},
                    Fault{"nan", "iterate", "is not finite"},
                    Fault{"missing_output", "iterate", "output \"velocity\" is missing"},
                    Fault{"deterministic", "deterministic", "value 0 of"},
                    Fault{"wrong_state", "wrong_state", "Error WRONG_STATE expected, got Error BAD_MESSAGE"},
                    Fault{"missing_input", "missing_input", "Error BAD_MESSAGE expected, got Iterated"},
                    Fault{"bad_shape", "bad_shape", "Error BAD_MESSAGE expected, got Iterated"},
                    Fault{"not_finite", "not_finite", "Error NOT_FINITE expected, got Iterated"},
                    Fault{"wrong_run", "wrong_run", "Error BAD_MESSAGE expected, got Iterated"},
                    Fault{"refusals", "refusals", "value 0 of \"displacement\""},
                    Fault{"repeat", "repeat", "repeated: "}, Fault{"pause", "pause", "exited with status 4"},
                    Fault{"rollback", "rollback", "step 1, iteration 1: value 0"},
                    Fault{"step_length", "step_length", "Done expected, got Error NUMERICAL"},
                    Fault{"checkpoint", "checkpoint", "step 2, iteration 1: value 0"},
                    Fault{"empty_checkpoint", "restore", "Restore: Done expected, got Error CONFIGURATION"},
                    Fault{"restore", "restore", "step 2, iteration 1: value 0"},
                    Fault{"resume", "resume", "step 2, iteration 1: value 0"},
                    Fault{"too_early", "resume", "aborted before Restore, it changed result.txt"},
                    Fault{"bad_checkpoint", "bad_checkpoint", "expected, got Done"},
                    Fault{"bad_mesh", "bad_mesh", "Error UNSUPPORTED expected, got Done"},
                    Fault{"beats", "beats", "0 in the 3."},
                    Fault{"version_refused", "version_refused", "Error UNSUPPORTED expected, got Done"},
                    Fault{"malformed", "malformed", "a wrong checksum: answered with Iterated"},
                    Fault{"shutdown", "shutdown", "in state ITERATED"},
                    Fault{"abort", "abort", "exited with status 0"},
                    Fault{"coupler_death", "coupler_death", "exited with status 0; status 4 expected"},
                    Fault{"silence", "silence", "exited with status 0; status 4 expected"},
                    Fault{"orphans", "orphans", "is still there"}),
    [](const auto& kind) { return std::string(kind.param.fault); });

TEST(Conform, APythonParticipantKeepsEveryPromise) {
  const auto folder = fresh_folder("python");
  const Judged j =
      conform(folder, {},
              {DROGUE_PYTHON, std::string(DROGUE_SOURCE_DIR) + "/tests/coupler/conform/broken_participant.py",
               "none"});
  EXPECT_EQ(j.status, 0) << j.text;
  EXPECT_EQ(j.with("pass").size(), 30u) << j.text;
}

} // namespace
} // namespace drogue::test
