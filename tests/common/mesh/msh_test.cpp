// SPDX-License-Identifier: GPL-3.0-or-later
#include "common/mesh/msh.hpp"

#include <gmock/gmock.h>
#include <gmsh.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <fstream>
#include <thread>

#include "common/fem/shape.hpp"
#include "common/mesh/gmsh_session.hpp"
#include "tests/common/mesh/meshes.hpp"

namespace drogue::mesh {
namespace {

using testing::HasSubstr;

std::filesystem::path temporary(const std::string& name) {
  return std::filesystem::path(testing::TempDir()) / ("drogue_msh_test_" + name);
}

std::filesystem::path written(const std::string& name, const std::string& content) {
  const auto file = temporary(name);
  std::ofstream(file) << content;
  return file;
}

bool same_bits(const std::vector<double>& a, const std::vector<double>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(double)) == 0;
}

std::string refusal(const std::filesystem::path& file) {
  const auto read = read_msh(file);
  if (read) return "accepted";
  EXPECT_EQ(read.error().kind, ErrorKind::config);
  EXPECT_THAT(read.error().message, HasSubstr(file.string()));
  return read.error().message;
}

/// Two triangles of which the second has the physical tag `tag`; MSH 2.2.
std::string two_triangles(const std::string& names, int tag, int type = 2) {
  return "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n" + names +
         "$Nodes\n4\n10 0 0 0\n20 1 0 0\n30 1 1 0\n40 0 1 0\n$EndNodes\n"
         "$Elements\n2\n1 2 2 5 1 10 20 30\n2 " +
         std::to_string(type) + " 2 " + std::to_string(tag) + " 2 10 30 40" + (type == 3 ? " 20" : "") +
         "\n$EndElements\n";
}

constexpr const char* names = "$PhysicalNames\n2\n2 5 \"left\"\n2 6 \"right\"\n$EndPhysicalNames\n";

TEST(Msh, RoundTripIsExact) {
  const Mesh mesh = test::every_kind();
  const auto file = temporary("round_trip.msh");
  ASSERT_TRUE(write_msh(file, mesh).ok());
  const auto read = read_msh(file);
  ASSERT_TRUE(read.ok()) << read.error().message;

  EXPECT_TRUE(same_bits(read->points, mesh.points));
  ASSERT_EQ(read->blocks.size(), mesh.blocks.size());
  for (std::size_t b = 0; b < mesh.blocks.size(); ++b) {
    EXPECT_EQ(read->blocks[b].group, mesh.blocks[b].group);
    EXPECT_EQ(read->blocks[b].kind, mesh.blocks[b].kind);
    EXPECT_EQ(read->blocks[b].nodes, mesh.blocks[b].nodes);
  }
  EXPECT_EQ(hash(*read), hash(mesh));
  ASSERT_EQ(read->node_fields.size(), 2U);
  for (const auto& [name, field] : mesh.node_fields) {
    ASSERT_EQ(read->node_fields.count(name), 1U) << name;
    EXPECT_EQ(read->node_fields.at(name).components, field.components);
    EXPECT_TRUE(same_bits(read->node_fields.at(name).values, field.values)) << name;
  }
}

/// Mesh files that are kept under other names, like the one that is about to be meshed anew, keep their
/// fields.
TEST(Msh, IsKnownByItsContentToo) {
  const Mesh mesh = test::every_kind();
  ASSERT_FALSE(mesh.node_fields.empty());
  const auto file = temporary("other_name.msh.before");
  ASSERT_TRUE(write_msh(file, mesh).ok());
  const auto read = read_msh(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(hash(*read), hash(mesh));
  ASSERT_EQ(read->node_fields.size(), mesh.node_fields.size());
  for (const auto& [name, field] : mesh.node_fields)
    EXPECT_TRUE(same_bits(read->node_fields.at(name).values, field.values)) << name;
}

TEST(Msh, WritesTheSameBytesAgain) {
  const auto first = temporary("first.msh"), second = temporary("second.msh");
  ASSERT_TRUE(write_msh(first, test::every_kind()).ok());
  ASSERT_TRUE(write_msh(second, read_msh(first).value()).ok());
  std::ifstream a(first, std::ios::binary), b(second, std::ios::binary);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(a), {}),
            std::string(std::istreambuf_iterator<char>(b), {}));
}

TEST(Msh, ReadsForeignMeshesInTheOrderOfTheirTags) {
  const auto read = read_msh(written("foreign.msh", two_triangles(names, 6)));
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_THAT(read->points, testing::ElementsAre(0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0));
  ASSERT_THAT(read->group_names(), testing::ElementsAre("left", "right"));
  EXPECT_THAT(read->blocks[1].nodes, testing::ElementsAre(0, 2, 3));
}

TEST(Msh, JoinsTheEntitiesOfAGroup) {
  const auto read = read_msh(written("joined.msh", two_triangles(names, 5)));
  ASSERT_TRUE(read.ok()) << read.error().message;
  ASSERT_EQ(read->blocks.size(), 1U);
  EXPECT_THAT(read->blocks[0].nodes, testing::ElementsAre(0, 1, 2, 0, 2, 3));
}

TEST(Msh, RefusesAMissingFile) {
  EXPECT_THAT(refusal(temporary("none.msh")), HasSubstr("there is no such file"));
}

TEST(Msh, RefusesGroupsWithoutNames) {
  EXPECT_THAT(refusal(written("unnamed.msh", two_triangles("", 6))), HasSubstr("has no name"));
}

TEST(Msh, RefusesElementsOutsideGroups) {
  EXPECT_THAT(refusal(written("loose.msh", two_triangles(names, 0))),
              HasSubstr("belong to no named physical group"));
}

TEST(Msh, RefusesUnknownKinds) {
  const std::string pyramid =
      "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$PhysicalNames\n1\n3 1 \"solid\"\n"
      "$EndPhysicalNames\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 1 1 0\n4 0 1 0\n5 0 0 1\n$EndNodes\n"
      "$Elements\n1\n1 7 2 1 1 1 2 3 4 5\n$EndElements\n";
  EXPECT_THAT(refusal(written("pyramid.msh", pyramid)), HasSubstr("Pyramid"));
}

TEST(Msh, RefusesUnusedNodes) {
  Mesh mesh = test::every_kind();
  mesh.node_fields.clear();
  mesh.points.insert(mesh.points.end(), {3, 3, 3});
  const auto file = temporary("orphan.msh");
  ASSERT_TRUE(write_msh(file, mesh).ok());
  EXPECT_THAT(refusal(file), HasSubstr("used by no element (the first is node 13)"));
}

TEST(Msh, RefusesDamagedFiles) {
  const auto file = temporary("whole.msh");
  ASSERT_TRUE(write_msh(file, test::every_kind()).ok());
  std::ifstream in(file, std::ios::binary);
  const std::string whole(std::istreambuf_iterator<char>(in), {});
  EXPECT_NE(refusal(written("truncated.msh", whole.substr(0, whole.find("$Elements") + 60))), "accepted");
  EXPECT_NE(refusal(written("empty.msh", "")), "accepted");
  EXPECT_NE(refusal(written("text.msh", "not a mesh at all\n")), "accepted");
}

TEST(Msh, RefusesToWriteWhatCannotBeRead) {
  const auto error_of = [](const Mesh& mesh) {
    const auto result = write_msh(temporary("refused.msh"), mesh);
    return result ? std::string("accepted") : result.error().message;
  };
  Mesh mesh = test::every_kind();
  mesh.blocks[0].group = "a \"quoted\" name";
  EXPECT_THAT(error_of(mesh), HasSubstr("is not allowed"));
  mesh = test::every_kind();
  mesh.blocks[0].nodes[0] = 12;
  EXPECT_THAT(error_of(mesh), HasSubstr("uses node 12 of 12"));
  mesh = test::every_kind();
  mesh.node_fields["complete"].values.pop_back();
  EXPECT_THAT(error_of(mesh), HasSubstr("field \"complete\" has 11 values"));
  EXPECT_THAT(error_of(Mesh{}), HasSubstr("no elements"));
  EXPECT_FALSE(std::filesystem::exists(temporary("refused.msh")));
}

/// Gmsh would take the first for a script, and read the others beyond their end.
TEST(Msh, RefusesFilesThatAreNoMesh) {
  const auto read = [](const std::string& text) {
    const auto file = temporary("no_mesh.msh");
    std::ofstream(file, std::ios::binary) << text;
    const auto mesh = read_msh(file);
    return mesh ? std::string() : mesh.error().message;
  };
  EXPECT_THAT(read("SystemCall \"true\";"), HasSubstr("does not begin with $MeshFormat"));
  EXPECT_THAT(read("$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n0 0 0 0\n"),
              HasSubstr("the section $Nodes has no $EndNodes"));
  EXPECT_THAT(read("$MeshFormat\n4.1 0 8\n$EndMeshFormat\nPoint(1) = {0, 0, 0};\n"),
              HasSubstr("after $EndMeshFormat another section must begin"));
}

TEST(Msh, ReadsFromSeveralThreads) {
  const auto file = temporary("threads.msh");
  ASSERT_TRUE(write_msh(file, test::every_kind()).ok());
  std::array<std::string, 4> hashes;
  std::array<std::thread, 4> threads;
  for (std::size_t i = 0; i < 4; ++i)
    threads[i] = std::thread([&, i] { hashes[i] = hash(read_msh(file).value()); });
  for (std::thread& thread : threads) thread.join();
  EXPECT_THAT(hashes, testing::Each(hash(test::every_kind())));
}

/// Our node orders are Gmsh's: its own coordinates of the nodes of a parent element.
TEST(Msh, NodeOrderOfVolumesIsGmshs) {
  const GmshSession session;
  for (const auto& [kind, type] :
       {std::pair{ElementKind::tet4, 4}, {ElementKind::tet10, 11}, {ElementKind::hex27, 12}}) {
    std::string name;
    int dimension = 0, order = 0, nodes = 0, primary = 0;
    std::vector<double> coordinates;
    gmsh::model::mesh::getElementProperties(type, name, dimension, order, nodes, coordinates, primary);
    ASSERT_EQ(nodes, nodes_per_element(kind)) << name;
    for (int a = 0; a < nodes; ++a)
      for (std::size_t c = 0; c < 3; ++c)
        EXPECT_EQ(fem::volume_node(kind, a)[c], coordinates[3 * static_cast<std::size_t>(a) + c])
            << name << " " << a;
  }
}

} // namespace
} // namespace drogue::mesh
