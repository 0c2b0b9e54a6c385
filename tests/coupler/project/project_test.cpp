// SPDX-License-Identifier: GPL-3.0-or-later
// `coupler project` as a user calls it: two surfaces in files, a field between them.
#include <gtest/gtest.h>

#include <regex>

#include "common/io/state_file.hpp"
#include "common/mesh/msh.hpp"
#include "coupler/launcher/process.hpp"
#include "parachute_mesher/structure_mesh.hpp"
#include "tests/coupler/projection/surfaces.hpp"
#include "tests/support/coupled_case.hpp"

namespace drogue::projection::test {
namespace {

using drogue::test::fresh_folder;
using drogue::test::read_text;

constexpr const char* wavy_text = "sin(4*x)*cos(3*y)+z; sin(4*y)*cos(3*z)+x; sin(4*z)*cos(3*x)+y";

class Project : public testing::Test {
 protected:
  Project() : folder_(fresh_folder("project")) {}

  void write(const std::string& file, const Surface& surface,
             const std::map<std::string, mesh::NodeField>& fields = {}) const {
    ASSERT_TRUE(mesh::write_msh(folder_ / file, {surface.points, surface.blocks, fields}).ok());
  }
  /// Exit status; what was printed is in text_.
  int run(const std::vector<std::string>& arguments) {
    std::vector<std::string> command{std::string(DROGUE_BIN_DIR) + "/coupler", "project"};
    command.insert(command.end(), arguments.begin(), arguments.end());
    auto process = launcher::Process::start({command, {}, folder_, folder_ / "output.txt"});
    if (!process) return -1;
    const auto& exit = process->wait(std::chrono::minutes(1));
    text_ = read_text(folder_ / "output.txt");
    return exit ? exit->status : -1;
  }
  /// The number behind `label` in what was printed.
  [[nodiscard]] double number(const std::string& label) const {
    std::smatch found;
    const std::regex pattern(label + " ([-+0-9.e]+)");
    return std::regex_search(text_, found, pattern) ? std::stod(found[1]) : std::nan("");
  }
  [[nodiscard]] bool says(const std::string& words) const { return text_.find(words) != std::string::npos; }

  std::filesystem::path folder_;
  std::string text_;
};

TEST_F(Project, PrintsErrorsAndBalancesOfAnExpression) {
  write("a.msh", octahedron_hemisphere(25));
  write("b.msh", lat_long_hemisphere(18));
  ASSERT_EQ(run({"a.msh", "b.msh", "-e", wavy_text}), 0) << text_;
  EXPECT_LT(number("displacement: relative error"), 5.4e-3);
  EXPECT_GT(number("displacement: relative error"), 1e-4);
  EXPECT_LT(number("recovered traction: relative error"), 8e-3);
  EXPECT_GT(number("recovered traction: relative error"), 1e-4);
  EXPECT_LT(number("force .*: defect"), 1e-12) << text_;
  EXPECT_LT(number("moment .*: defect"), 1e-3);
  EXPECT_EQ(number("unmatched area"), 0);
  EXPECT_GT(number("largest gap"), 1e-5);
  EXPECT_GT(number("angle of the normals"), 1);
  EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "projected.vtu"));
}

TEST_F(Project, TakesAFieldOfTheFileAndNamedGroups) {
  Surface two = plate(ElementKind::tri3, 4);
  two.blocks[0].group = "lower";
  Surface upper = plate(ElementKind::tri3, 4);
  for (std::size_t i = 2; i < upper.points.size(); i += 3) upper.points[i] = 1;
  upper.blocks[0].group = "upper";
  two = combine_surfaces(two, upper);
  mesh::NodeField height{1, {}};
  for (std::size_t i = 0; i < two.points.size(); i += 3) height.values.push_back(2 + two.points[i + 2]);
  write("two.msh", two, {{"height", height}});
  write("one.msh", plate(ElementKind::quad9, 3));
  ASSERT_EQ(run({"two.msh", "one.msh", "--from-group", "lower", "-f", "height", "-o", "out.vtu"}), 0)
      << text_;
  EXPECT_TRUE(says("force (2, 0, 0) given, (2, 0, 0) received")) << text_; // 2 over an area of one
  EXPECT_TRUE(std::filesystem::is_regular_file(folder_ / "out.vtu"));
  EXPECT_EQ(run({"two.msh", "one.msh", "-f", "height"}), 2);
  EXPECT_TRUE(says("name one of them: lower, upper")) << text_;
  EXPECT_EQ(run({"two.msh", "one.msh", "--from-group", "uper", "-f", "height"}), 2);
  EXPECT_TRUE(says("no surface named \"uper\" (there are: lower, upper)")) << text_;
  EXPECT_EQ(run({"two.msh", "one.msh", "--from-group", "upper", "-f", "height"}), 2);
  EXPECT_TRUE(says("do not lie on one another")) << text_;
  EXPECT_EQ(run({"one.msh", "one.msh", "-f", "height"}), 2);
  EXPECT_TRUE(says("has no field \"height\"")) << text_;
}

TEST_F(Project, RefusesWhatDoesNotFit) {
  Surface shifted = plate(ElementKind::tri3, 5), bent = plate(ElementKind::tri3, 8);
  for (std::size_t i = 0; i < shifted.points.size(); i += 3) shifted.points[i] += 0.25;
  for (std::size_t i = 0; i < bent.points.size(); i += 3)
    bent.points[i + 2] = 0.02 * std::cos(25 * bent.points[i]);
  write("plate.msh", plate(ElementKind::tri3, 4));
  write("shifted.msh", shifted);
  write("bent.msh", bent);
  EXPECT_EQ(run({"plate.msh", "shifted.msh", "-e", "1"}), 2);
  EXPECT_TRUE(says("do not lie on one another")) << text_;
  EXPECT_TRUE(says("raise projection.largest_gap")) << text_;
  EXPECT_EQ(run({"plate.msh", "shifted.msh", "-e", "1", "--largest-unmatched-area", "0.3"}), 0) << text_;
  EXPECT_NEAR(number("unmatched area"), 22, 4) << text_; // a quarter less the gap allowed
  EXPECT_LT(number("force .*: defect"), 1e-12);
  EXPECT_EQ(run({"plate.msh", "bent.msh", "-e", "1"}), 0) << text_;
  EXPECT_EQ(run({"plate.msh", "bent.msh", "-e", "1", "--largest-normal-angle", "5"}), 2);
  EXPECT_TRUE(says("degrees to one another")) << text_;
  EXPECT_EQ(run({"plate.msh", "bent.msh", "-e", "1; 2"}), 2);
  EXPECT_TRUE(says("one or three are expected")) << text_;
  EXPECT_EQ(run({"plate.msh", "bent.msh", "-e", "1/(x-x); 2; 3"}), 2);
  EXPECT_TRUE(says("not finite")) << text_;
  EXPECT_EQ(run({"plate.msh", "bent.msh"}), 2);
}

/// A flat extended skirt with all its lines, and a state of it.
class ProjectState : public Project {
 protected:
  static mesh::Mesh canopy(ElementKind kind, parachute::Subdivision rows) {
    const parachute::Canopy cloth{.diameter = 10, .vent_ratio = 0.1, .skirt_ratio = 0.1, .gores = 12};
    const parachute::Rigging lines{
        .line_length = 12, .line_elements = 5, .vent_elements = 2, .confluence_distance = 0.5};
    return parachute::structure_mesh(
        cloth, lines, {.file = {}, .element = kind, .rows = parachute::cloth_rows(cloth, rows)});
  }
  void write(const std::string& name, const mesh::Mesh& m,
             const std::function<Point(const Point&)>& f) const {
    ASSERT_TRUE(mesh::write_msh(folder_ / (name + ".msh"), m).ok());
    const auto read = mesh::read_msh(folder_ / (name + ".msh"));
    ASSERT_TRUE(read.ok());
    std::vector<double> u, zero(m.points.size(), 0.0), ones(m.points.size(), 1.0);
    for (std::size_t i = 0; i < m.points.size(); i += 3)
      for (const double value : f({m.points[i], m.points[i + 1], m.points[i + 2]})) u.push_back(value);
    io::State state{"structure", mesh::hash(*read), 1.5, 7, {}};
    const std::vector<std::uint64_t> shape{m.points.size() / 3, 3};
    state.add("displacement", shape, u);
    state.add("velocity", shape, ones);
    state.add("acceleration", shape, zero);
    ASSERT_TRUE(io::write_state(folder_ / (name + ".state"), state).ok());
  }
};

TEST_F(ProjectState, CarriesClothAndLinesToAnotherMesh) {
  // Bilinear: Q9 and the fine T3 of this pattern differ little, lines not at all where they are linear.
  const auto f = [](const Point& x) { return Point{1 + 0.1 * x[0], 0.2 * x[1] - 0.1 * x[2], 0.3 * x[2]}; };
  const mesh::Mesh to =
      canopy(ElementKind::quad9,
             {.main_rows = 5, .skirt_rows = 1, .across_vent = 2, .across_seam = 2, .across_skirt = 2});
  write("from",
        canopy(ElementKind::tri3,
               {.main_rows = 12, .skirt_rows = 3, .across_vent = 1, .across_seam = 4, .across_skirt = 4}),
        f);
  write("to", to, f);
  ASSERT_EQ(run({"from.msh", "to.msh", "--state", "from.state", "--output", "out.state"}), 0) << text_;
  EXPECT_LT(number("displacement:"), 1e-3) << text_;
  const auto made = io::read_state(folder_ / "out.state"), expected = io::read_state(folder_ / "to.state");
  ASSERT_TRUE(made.ok() && expected.ok());
  EXPECT_EQ(made->mesh_hash, expected->mesh_hash);
  EXPECT_EQ(made->time, 1.5);
  EXPECT_EQ(made->step, 7u);
  EXPECT_LT(relative_error(made->find("displacement")->values, expected->find("displacement")->values), 1e-3);
  EXPECT_LT(largest_difference(made->find("velocity")->values, expected->find("velocity")->values), 1e-12);
  EXPECT_EQ(largest_difference(made->find("acceleration")->values, expected->find("acceleration")->values),
            0);
  for (const std::int32_t node : to.nodes_of("confluence"))
    for (std::size_t c = 0; c < 3; ++c) {
      const std::size_t i = 3 * static_cast<std::size_t>(node) + c;
      EXPECT_NEAR(made->find("displacement")->values[i], expected->find("displacement")->values[i], 1e-12);
    }
}

TEST_F(ProjectState, RefusesWhatDoesNotFit) {
  const auto still = [](const Point&) { return Point{}; };
  const parachute::Subdivision rows{
      .main_rows = 4, .skirt_rows = 1, .across_vent = 2, .across_seam = 2, .across_skirt = 2};
  mesh::Mesh a = canopy(ElementKind::quad9, rows), b = canopy(ElementKind::tri3, rows), far = a;
  write("a", a, still);
  write("b", b, still);
  EXPECT_EQ(run({"a.msh", "b.msh", "--state", "b.state"}), 2);
  EXPECT_TRUE(says("belongs to another mesh")) << text_;
  for (mesh::ElementBlock& block : b.blocks)
    if (block.group == "vent_lines") block.group = "strings";
  write("b", b, still);
  EXPECT_EQ(run({"a.msh", "b.msh", "--state", "a.state"}), 2);
  EXPECT_TRUE(says("has no lines \"strings\"")) << text_;
  for (const std::int32_t node : far.nodes_of("confluence"))
    far.points[3 * static_cast<std::size_t>(node) + 2] -= 4;
  write("far", far, still);
  EXPECT_EQ(run({"a.msh", "far.msh", "--state", "a.state"}), 2);
  EXPECT_TRUE(says("from the lines of that name")) << text_;
}

} // namespace
} // namespace drogue::projection::test
