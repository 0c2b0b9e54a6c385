// SPDX-License-Identifier: GPL-3.0-or-later
#include "parachute_mesher/commands.hpp"

#include <unistd.h>

#include <cstdlib>
#include <fstream>
#include <sstream>

#include <gtest/gtest.h>

#include "common/io/state_file.hpp"
#include "common/mesh/msh.hpp"
#include "parachute_mesher/settings.hpp"
#include "tests/parachute_mesher/inflated_shape.hpp"

namespace drogue::parachute {
namespace {

namespace fs = std::filesystem;

std::string contents(const fs::path& file) {
  std::ifstream stream(file, std::ios::binary);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

/// A folder with the quick case's config, removed afterwards.
class Commands : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / fmt::format("parachute_mesher_test_{}", ::getpid());
    fs::create_directories(folder_);
    fs::copy_file(fs::path(DROGUE_SOURCE_DIR) / "configs/t10/quick/parachute.textproto", config());
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] fs::path config() const { return folder_ / "parachute.textproto"; }
  void replace(const std::string& from, const std::string& to) const {
    std::string text = contents(config());
    const std::size_t at = text.find(from);
    ASSERT_NE(at, std::string::npos) << from;
    std::ofstream(config(), std::ios::trunc) << text.replace(at, from.size(), to);
  }
  /// Writes the structure mesh and an inflated state of it, its displacement times a factor.
  void prepare_structure(double factor = 1) const {
    const Result<void> written = write_structure_mesh(config());
    ASSERT_TRUE(written.ok()) << written.error().message;
    const Result<mesh::Mesh> m = mesh::read_msh(folder_ / "structure.msh");
    ASSERT_TRUE(m.ok()) << m.error().message;
    const Result<Settings> settings = load_settings(config());
    ASSERT_TRUE(settings.ok());
    io::State state{.kind = "structure", .mesh_hash = mesh::hash(*m), .time = 0, .step = 0, .arrays = {}};
    std::vector<double> displacement = inflated_displacement(settings->canopy, *m);
    for (double& u : displacement) u *= factor;
    state.add("displacement", {static_cast<std::uint64_t>(m->node_count()), 3}, std::move(displacement));
    ASSERT_TRUE(io::write_state(folder_ / "inflated.state", state).ok());
  }
  [[nodiscard]] int run(const std::string& arguments, const char* program = "parachute_mesher") const {
    const std::string command = fmt::format("cd {} && {}/{} {} > out.txt 2> err.txt", folder_.string(),
                                            DROGUE_BIN_DIR, program, arguments);
    return WEXITSTATUS(std::system(command.c_str()));
  }

  fs::path folder_;
};

TEST_F(Commands, MakeTheSameFluidMeshEveryTime) {
  prepare_structure();
  replace("growth: 0.22", "growth: 0.3");
  replace("wake_length: 1.6", "wake_length: 0");
  ASSERT_EQ(run("fluid parachute.textproto"), 0) << contents(folder_ / "err.txt");
  const std::string first = contents(folder_ / "fluid.msh");
  ASSERT_EQ(run("fluid ./../" + folder_.filename().string() + "/parachute.textproto"), 0);
  EXPECT_TRUE(first == contents(folder_ / "fluid.msh"));
}

TEST_F(Commands, MakeTheQuickFluidMesh) {
  prepare_structure();
  ASSERT_EQ(run("fluid parachute.textproto"), 0) << contents(folder_ / "err.txt");
  const Result<mesh::Mesh> m = mesh::read_msh(folder_ / "fluid.msh");
  ASSERT_TRUE(m.ok()) << m.error().message;
  EXPECT_GE(m->node_count(), 10000);
  EXPECT_LE(m->node_count(), 13500);
  for (const char* group : {"inflow", "outflow", "side", "canopy_upper", "canopy_lower", "fluid"})
    EXPECT_TRUE(m->has_group(group)) << group;
  EXPECT_EQ(m->nodes_of("canopy_upper").size(), m->nodes_of("canopy_lower").size());

  ASSERT_EQ(run("info fluid.msh"), 0);
  const std::string text = contents(folder_ / "out.txt");
  EXPECT_NE(text.find("conforming, every boundary face named"), std::string::npos) << text;
  EXPECT_NE(text.find("2 free edges, both sides together closed"), std::string::npos) << text;
}

TEST_F(Commands, CheckAcceptsThePapersConfigs) {
  for (const char* name : {"compatible", "incompatible", "free_fall"}) {
    fs::copy_file(fs::path(DROGUE_SOURCE_DIR) / "configs/t10" / name / "parachute.textproto", config(),
                  fs::copy_options::overwrite_existing);
    EXPECT_EQ(run("check parachute.textproto"), 0) << name << ": " << contents(folder_ / "err.txt");
  }
}

TEST_F(Commands, StructureSolverFliesTheFreeFallCaseWithItsPayload) {
  for (const char* name : {"parachute", "inflation", "structure"})
    fs::copy_file(fs::path(DROGUE_SOURCE_DIR) / "configs/t10/free_fall" / fmt::format("{}.textproto", name),
                  folder_ / fmt::format("{}.textproto", name), fs::copy_options::overwrite_existing);
  ASSERT_EQ(run("structure parachute.textproto"), 0) << contents(folder_ / "err.txt");
  EXPECT_EQ(run("check inflation.textproto", "structure_solver"), 0) << contents(folder_ / "err.txt");
  // From the flat pattern, where the inflation would take half a minute, and stand-alone.
  std::string text = contents(folder_ / "structure.textproto");
  for (const char* line : {"initial_state: \"inflated.state\"", "initial_at_rest: true",
                           "interface: \"canopy\"", "iterations_per_coupling: 1"})
    text.replace(text.find(line), std::string(line).size(), "");
  text.replace(text.find("step: 0.0032"), 12, "step: 0.001 steps: 3");
  std::ofstream(folder_ / "structure.textproto", std::ios::trunc) << text;
  EXPECT_EQ(run("run structure.textproto", "structure_solver"), 0) << contents(folder_ / "err.txt");
}

TEST_F(Commands, CheckAcceptsTheQuickConfigBeforeAnyMeshExists) {
  EXPECT_EQ(run("check parachute.textproto"), 0);
  EXPECT_EQ(contents(folder_ / "out.txt"), "parachute.textproto: ok\n");
}

TEST_F(Commands, CheckReportsEveryError) {
  replace("across_seam: 2", "across_seam: 3");
  replace("line_length: 29.4", "line_length: 12");
  replace("largest_size: 32", "largest_size: 1");
  replace("skirt_rows: 3", "skirt_rows: 0");
  EXPECT_EQ(run("check parachute.textproto"), 2);
  const std::string text = contents(folder_ / "err.txt");
  for (const char* part :
       {"parachute.textproto:12:", "does not reach the axis", "same number of elements across",
        "largest_size 1 is below canopy_size", "skirt_rows is 0"})
    EXPECT_NE(text.find(part), std::string::npos) << part << "\n" << text;
}

TEST_F(Commands, FluidNeedsTheStructureFirst) {
  EXPECT_EQ(run("fluid parachute.textproto"), 2);
  EXPECT_NE(contents(folder_ / "err.txt").find("structure.msh"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "fluid.msh"));
}

TEST_F(Commands, FluidNamesTheTrianglesWhereTheCanopyCrossesItself) {
  prepare_structure(0); // the flat pattern, in which the skirt lies on the disk
  EXPECT_EQ(run("fluid parachute.textproto"), 3);
  const std::string text = contents(folder_ / "err.txt");
  EXPECT_NE(text.find("crosses or touches itself: its triangle "), std::string::npos) << text;
  EXPECT_FALSE(fs::exists(folder_ / "fluid.msh"));
}

TEST_F(Commands, InfoDescribesABadMeshAndFails) {
  // Two tetrahedra in a box of two; the second is inverted.
  mesh::Mesh m;
  m.points = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1};
  m.blocks = {{"wall", mesh::ElementKind::tri3, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 4, 2, 3, 4, 3, 1, 4}},
              {"fluid", mesh::ElementKind::tet4, {0, 1, 2, 3, 1, 2, 3, 4}}};
  ASSERT_TRUE(mesh::write_msh(folder_ / "good.msh", m).ok());
  EXPECT_EQ(run("info good.msh"), 0) << contents(folder_ / "err.txt");
  EXPECT_NE(contents(folder_ / "out.txt").find("smallest dihedral angle"), std::string::npos);
  std::swap(m.blocks[1].nodes[4], m.blocks[1].nodes[5]);
  ASSERT_TRUE(mesh::write_msh(folder_ / "inverted.msh", m).ok());
  EXPECT_EQ(run("info inverted.msh"), 3);
  EXPECT_NE(contents(folder_ / "err.txt").find("the first is the tetrahedron of the nodes 2, 1, 3, 4"),
            std::string::npos)
      << contents(folder_ / "err.txt");
  EXPECT_NE(contents(folder_ / "out.txt").find("fluid "), std::string::npos);
  std::swap(m.blocks[1].nodes[4], m.blocks[1].nodes[5]);
  m.points.insert(m.points.end(), {5, 5, 5}); // no element uses it
  ASSERT_TRUE(mesh::write_msh(folder_ / "orphan.msh", m).ok());
  EXPECT_EQ(run("info orphan.msh"), 2);
  EXPECT_NE(contents(folder_ / "err.txt").find("the first is node 6"), std::string::npos)
      << contents(folder_ / "err.txt");
}

TEST_F(Commands, FluidRefusesTheStateOfAnotherMesh) {
  prepare_structure();
  replace("line_elements: 10", "line_elements: 9");
  ASSERT_EQ(run("structure parachute.textproto"), 0);
  EXPECT_EQ(run("fluid parachute.textproto"), 2);
  EXPECT_NE(contents(folder_ / "err.txt").find("another mesh"), std::string::npos);
  EXPECT_FALSE(fs::exists(folder_ / "fluid.msh"));
}

TEST_F(Commands, CommandLineErrorsExitWithTwo) {
  EXPECT_EQ(run("fluid"), 2);
  EXPECT_EQ(run("melt parachute.textproto"), 2);
  EXPECT_EQ(run("structure missing.textproto"), 2);
  EXPECT_EQ(run("--help"), 0);
}

} // namespace
} // namespace drogue::parachute
