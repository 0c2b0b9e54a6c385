// SPDX-License-Identifier: GPL-3.0-or-later
// Every file of tests/config_invalid is refused by its program's `check`, with the message and position that
// the file itself announces:
//   # check: structure_solver            (or "# check: structure_solver --participant")
//   # expect: 7:3: error: part of the message      (one line for each expected error; no others may come)
#include <algorithm>

#include "common/mesh/msh.hpp"
#include "coupler/launcher/process.hpp"
#include "tests/mesh_mover/box_mesh.hpp"
#include "tests/mesh_mover/plane_mesh.hpp"
#include "tests/support/coupled_case.hpp"

namespace drogue::test {
namespace {

namespace fs = std::filesystem;

std::vector<std::string> tagged_lines(const fs::path& file, const std::string& tag) {
  std::ifstream stream(file);
  std::vector<std::string> found;
  for (std::string line; std::getline(stream, line);)
    if (line.rfind("# " + tag + ": ", 0) == 0) found.push_back(line.substr(tag.size() + 4));
  return found;
}

std::vector<fs::path> invalid_files() {
  std::vector<fs::path> files;
  for (const auto& entry : fs::directory_iterator(fs::path(DROGUE_SOURCE_DIR) / "tests/config_invalid"))
    if (entry.path().extension() == ".textproto") files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

/// box.msh: a box of tetrahedra with sides x0 ... z1; plane.msh: a rectangle of triangles with sides x0 ...
/// y1; patch.msh: a membrane "canopy" and a cable "line".
void write_meshes(const fs::path& folder) {
  const auto grid = uniform(0, 1, 2);
  ASSERT_TRUE(
      mesh::write_msh(folder / "box.msh", box_mesh({grid, grid, grid}, [](int, int, int) { return false; })));
  ASSERT_TRUE(mesh::write_msh(folder / "plane.msh", plane_mesh(grid, grid, [](int, int) { return false; })));
  mesh::Mesh patch;
  patch.points = {0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, 0, 0, -1};
  patch.blocks = {{"canopy", mesh::ElementKind::tri3, {0, 1, 2, 0, 2, 3}},
                  {"line", mesh::ElementKind::line2, {0, 4}}};
  ASSERT_TRUE(mesh::write_msh(folder / "patch.msh", patch));
}

class InvalidConfig : public testing::TestWithParam<fs::path> {};

TEST_P(InvalidConfig, IsRefusedAsAnnounced) {
  const fs::path file = GetParam();
  const auto program = tagged_lines(file, "check"), expected = tagged_lines(file, "expect");
  ASSERT_EQ(program.size(), 1u) << "no '# check: PROGRAM' line";
  std::istringstream words(program[0]);
  std::string name;
  words >> name;
  std::vector<std::string> command{fmt::format("{}/{}", DROGUE_BIN_DIR, name), "check", file.filename()};
  for (std::string option; words >> option;) command.push_back(option);
  ASSERT_FALSE(expected.empty()) << "no '# expect: ...' line";
  const auto folder = fresh_folder(file.stem().string());
  write_meshes(folder);
  for (const fs::path& each : invalid_files())
    fs::copy_file(each, folder / each.filename()); // a case may name others

  auto process = launcher::Process::start(
      {command, {"OMPI_MCA_ess_singleton_isolated=1"}, folder, folder / "output.txt"});
  ASSERT_TRUE(process.ok());
  const auto& exit = process->wait(std::chrono::seconds(30));
  ASSERT_TRUE(exit.has_value());
  EXPECT_EQ(exit->status, 2);

  const std::string output = read_text(folder / "output.txt");
  for (const std::string& line : expected)
    EXPECT_NE(output.find(line), std::string::npos) << line << "\nin:\n" << output;
  std::size_t errors = 0;
  for (std::size_t at = output.find(": error: "); at != std::string::npos;
       at = output.find(": error: ", at + 1))
    ++errors;
  EXPECT_EQ(errors, expected.size()) << output;
}

INSTANTIATE_TEST_SUITE_P(Files, InvalidConfig, testing::ValuesIn(invalid_files()), [](const auto& file) {
  std::string name = file.param.stem().string();
  std::replace_if(
      name.begin(), name.end(), [](char c) { return !std::isalnum(static_cast<unsigned char>(c)); }, '_');
  return name;
});

} // namespace
} // namespace drogue::test
