// SPDX-License-Identifier: GPL-3.0-or-later
#include <gtest/gtest.h>

#include <cstdlib>
#include <numeric>

#include "common/fem/shape.hpp"
#include "common/io/vtu.hpp"
#include "common/mesh/msh.hpp"

namespace drogue {
namespace {

using mesh::ElementKind;

/// Point i is (0.3 i, 0.3 i + 0.1, 0.3 i + 0.2): the formula that the scripts repeat.
std::vector<double> points(std::int32_t count) {
  std::vector<double> x;
  for (std::int32_t i = 0; i < 3 * count; ++i) x.push_back(0.1 * i);
  return x;
}

std::vector<mesh::ElementBlock> every_kind() {
  std::vector<mesh::ElementBlock> blocks;
  for (const ElementKind kind : {ElementKind::hex27, ElementKind::tet10, ElementKind::tet4, ElementKind::tri3,
                                 ElementKind::tri6, ElementKind::quad4, ElementKind::quad9,
                                 ElementKind::line2, ElementKind::line3, ElementKind::point1}) {
    mesh::ElementBlock block{
        "group " + std::to_string(mesh::nodes_per_element(kind)) + "/" +
            std::to_string(mesh::dimension(kind)),
        kind, std::vector<std::int32_t>(static_cast<std::size_t>(mesh::nodes_per_element(kind)))};
    std::iota(block.nodes.begin(), block.nodes.end(), 1);
    blocks.push_back(block);
  }
  return blocks;
}

void expect_script_accepts(const std::string& script, const std::string& arguments) {
  const std::string command =
      std::string(DROGUE_PYTHON " " DROGUE_SOURCE_DIR "/tests/common/io/") + script + " " + arguments;
  EXPECT_EQ(std::system(command.c_str()), 0) << command;
}

std::string folder(const std::string& name) {
  const auto path = std::filesystem::path(testing::TempDir()) / ("drogue_foreign_" + name);
  std::filesystem::remove_all(path);
  std::filesystem::create_directories(path);
  return path.string();
}

TEST(ForeignReaders, VtuAndPvd) {
  const std::string out = folder("vtu");
  const auto x = points(28);
  const auto kinds = every_kind();
  io::VtuData data;
  data.points = x;
  for (const auto& block : kinds) data.blocks.push_back(&block);
  std::vector<double> cell_values(kinds.size());
  std::iota(cell_values.begin(), cell_values.end(), 0.0);
  data.point_data = {{"velocity", 3, x}};
  data.cell_data = {{"cell <index> & \"name\"", 1, cell_values}};
  io::PvdCollection collection(out + "/all.pvd");
  ASSERT_TRUE(io::write_vtu(out + "/kinds.vtu", data).ok());
  ASSERT_TRUE(collection.add(0.25, out + "/kinds.vtu").ok());

  // One element each on its parent domain: the script compares with VTK's own parent coordinates.
  for (const ElementKind kind : {ElementKind::tet10, ElementKind::hex27}) {
    const int n = mesh::nodes_per_element(kind);
    std::vector<double> parent;
    for (int a = 0; a < n; ++a)
      for (const double c : fem::volume_node(kind, a))
        parent.push_back(kind == ElementKind::hex27 ? 0.5 * (1 + c) : c);
    mesh::ElementBlock block{"parent", kind, std::vector<std::int32_t>(static_cast<std::size_t>(n))};
    std::iota(block.nodes.begin(), block.nodes.end(), 0);
    ASSERT_TRUE(
        io::write_vtu(out + "/parent_" + std::to_string(n) + ".vtu", {parent, {&block}, {}, {}}).ok());
  }

  // Arrays over several compression blocks; "whole_blocks" ends at the end of one.
  const std::int32_t count = 65536;
  const auto many = points(count);
  mesh::ElementBlock cloud{"cloud", ElementKind::point1, std::vector<std::int32_t>(count)};
  std::iota(cloud.nodes.begin(), cloud.nodes.end(), 0);
  const std::span<const double> whole(many.data(), count);
  ASSERT_TRUE(io::write_vtu(out + "/large.vtu", {many, {&cloud}, {{"whole_blocks", 1, whole}}, {}}).ok());
  ASSERT_TRUE(collection.add(0.5, out + "/large.vtu").ok());

  ASSERT_TRUE(io::write_vtu(out + "/empty.vtu", {}).ok());
  expect_script_accepts("read_vtu.py", out);
}

TEST(ForeignReaders, Msh) {
  const std::string out = folder("msh");
  const mesh::Mesh mesh{points(28), every_kind(), {{"field", {3, points(28)}}}};
  ASSERT_TRUE(mesh::write_msh(out + "/kinds.msh", mesh).ok());
  expect_script_accepts("read_msh.py", out + "/kinds.msh");
}

} // namespace
} // namespace drogue
