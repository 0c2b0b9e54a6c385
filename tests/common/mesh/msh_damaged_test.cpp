// SPDX-License-Identifier: GPL-3.0-or-later
// Damaged mesh files of both versions and forms: each is refused with what is wrong and where, or holds a
// mesh all the same; none is read beyond its end.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <fstream>
#include <string>
#include <utility>

#include "common/mesh/msh.hpp"

namespace drogue::mesh {
namespace {

using testing::HasSubstr;

std::string corpus(const std::string& name) {
  std::ifstream in(std::string(DROGUE_SOURCE_DIR) + "/fuzz/corpus/mesh/" + name, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}

Result<Mesh> read(const std::string& content) {
  const auto file = std::filesystem::path(testing::TempDir()) / "drogue_damaged_test.msh";
  std::ofstream(file, std::ios::binary) << content;
  return read_msh(file);
}

std::string refusal(const std::string& content) {
  const auto mesh = read(content);
  return mesh ? "accepted" : mesh.error().message;
}

std::string replaced(std::string text, const std::string& part, const std::string& by) {
  const std::size_t at = text.find(part);
  EXPECT_NE(at, std::string::npos) << part;
  return at == std::string::npos ? text : text.replace(at, part.size(), by);
}

template <class T>
std::string bytes(T value) {
  std::string text(sizeof value, '\0');
  std::memcpy(text.data(), &value, sizeof value);
  return text;
}

bool holds_together(const Mesh& mesh) {
  for (const ElementBlock& block : mesh.blocks)
    for (const std::int32_t node : block.nodes)
      if (node < 0 || node >= mesh.node_count()) return false;
  return true;
}

class DamagedMsh : public testing::TestWithParam<const char*> {};

TEST_P(DamagedMsh, IsReadWhole) {
  const auto mesh = read(corpus(GetParam()));
  ASSERT_TRUE(mesh.ok()) << mesh.error().message;
  EXPECT_EQ(mesh->node_count(), 14);
  EXPECT_EQ(hash(*mesh), hash(read(corpus("ascii22")).value()));
  EXPECT_THAT(mesh->group_names(), testing::ElementsAre("wall", "fluid"));
}

TEST_P(DamagedMsh, IsRefusedWhereverItIsCut) {
  const std::string whole = corpus(GetParam());
  const std::size_t last = whole.rfind("\n$EndElements");
  ASSERT_NE(last, std::string::npos);
  for (std::size_t size = 0; size < last + std::strlen("\n$EndElements"); ++size)
    ASSERT_NE(refusal(whole.substr(0, size)), "accepted") << size;
}

TEST_P(DamagedMsh, IsRefusedOrHoldsTogetherWhateverAByteIs) {
  constexpr std::array<char, 3> spoilt{'\0', '7', '\xff'};
  std::string content = corpus(GetParam());
  for (std::size_t at = 0; at < content.size(); ++at) {
    const char before = std::exchange(content[at], spoilt[at % 3]);
    const auto mesh = read(content);
    if (mesh)
      ASSERT_TRUE(holds_together(*mesh)) << at;
    else
      ASSERT_EQ(mesh.error().kind, ErrorKind::config) << at;
    content[at] = before;
  }
}

INSTANTIATE_TEST_SUITE_P(Forms, DamagedMsh, testing::Values("ascii22", "binary22", "ascii41", "binary41"),
                         [](const auto& form) { return std::string(form.param); });

TEST(DamagedMshText, OldTextSaysWhatAndWhere) {
  const std::string whole = corpus("ascii22");
  const auto refused = [&](const char* part, const char* by) { return refusal(replaced(whole, part, by)); };
  EXPECT_THAT(refused("$Nodes\n14", "$Nodes\n15"),
              HasSubstr(".msh:25: a whole number expected, not \"$EndNodes\""));
  EXPECT_THAT(refused("$Nodes\n14", "$Nodes\n13"),
              HasSubstr(".msh:24: the section $Nodes holds more than it announces: $EndNodes expected"));
  EXPECT_THAT(refused("$Nodes\n14", "$Nodes\n99999999999999"),
              HasSubstr("99999999999999 nodes do not fit into the"));
  EXPECT_THAT(refused("$Nodes\n14", "$Nodes\n-1"), HasSubstr(".msh:10: a whole number expected, not \"-1\""));
  EXPECT_THAT(refused("2 0 0 0", "2 0 x 0"), HasSubstr(".msh:12: a number expected, not \"x\""));
  EXPECT_THAT(refused("2 0 0 0", "2 0 nan 0"), HasSubstr("a coordinate of node 2 is not finite"));
  EXPECT_THAT(refused("2 0 0 0", "1 0 0 0"), HasSubstr("node 1 appears twice"));
  EXPECT_THAT(refused("2 0 0 0", "0 0 0 0"), HasSubstr(".msh:12: number 0 of a node or an element"));
  EXPECT_THAT(refused("1 2 2 2 1 2 1 9", "1 2 2 2 1 2 1 99"),
              HasSubstr("element 1 uses node 99, which is not there"));
  EXPECT_THAT(refused("1 2 2 2 1 2 1 9", "1 -2 2 2 1 2 1 9"),
              HasSubstr(".msh:28: elements of the unknown kind -2"));
  EXPECT_THAT(refused("1 2 2 2 1 2 1 9", "1 2 999999 2 1 2 1 9"), HasSubstr("do not fit into the"));
  EXPECT_THAT(refused("1 2 2 2 1 2 1 9", "1 2 -1 2 1 2 1 9"), HasSubstr("1 elements with -1 tags each"));
  EXPECT_THAT(refused("2 2 \"wall\"", "2 2 wall"), HasSubstr(".msh:6: a name in quotes expected"));
  EXPECT_THAT(refused("2.2 0 8", "3 0 8"), HasSubstr("version 3: save the mesh in version 4.1 or 2.2"));
  EXPECT_THAT(refused("2.2 0 8", "2.2 0 4"), HasSubstr("numbers of 4 bytes"));
}

TEST(DamagedMshText, EntitiesAreInFewGroups) {
  const std::string volume = " 1.0000001 1 1 6 1 2 3 4 5 6";
  std::string many;
  for (int group = 1; group <= 101; ++group) many += " " + std::to_string(group);
  EXPECT_THAT(refusal(replaced(corpus("ascii41"), volume, " 1.0000001 101" + many + " 6 1 2 3 4 5 6")),
              HasSubstr(".msh:37: an entity in 101 physical groups: at most 100 expected"));
}

TEST(DamagedMshText, BinarySaysWhatAndWhere) {
  const std::string old = corpus("binary22"), current = corpus("binary41");
  EXPECT_THAT(refusal(replaced(old, bytes(1), bytes(0x01000000))), HasSubstr("the order of the bytes"));
  const std::string head =
      "$Elements\n48\n" + bytes(2); // triangles; then how many, and with how many tags each
  EXPECT_THAT(refusal(replaced(old, head + bytes(1), head + bytes(1 << 30))),
              HasSubstr("1073741824 elements with 2 tags each, where 48 elements are left"));
  EXPECT_THAT(refusal(replaced(old, head + bytes(1) + bytes(2), head + bytes(1) + bytes(1 << 30))),
              HasSubstr("do not fit into the"));
  const std::string counts = "$Elements\n" + bytes<std::uint64_t>(7);
  EXPECT_THAT(refusal(replaced(current, counts, "$Elements\n" + bytes<std::uint64_t>(~0ULL))),
              HasSubstr("18446744073709551615 blocks of elements do not fit"));
  EXPECT_THAT(
      refusal(replaced(current, counts + bytes<std::uint64_t>(48), counts + bytes<std::uint64_t>(47))),
      HasSubstr("47 elements are announced, 48 are there"));
}

TEST(DamagedMshText, FieldsAreChecked) {
  const auto refused = [&](const std::string& data) {
    return refusal(corpus("ascii22") + "$NodeData\n1\n\"p\"\n1\n0\n" + data + "\n$EndNodeData\n");
  };
  EXPECT_EQ(refused("3\n0\n1\n1\n1 0.5"), "accepted");
  EXPECT_THAT(refused("3\n0\n1\n1\n99 0.5"),
              HasSubstr("field \"p\" has a value on node 99, which is not there"));
  EXPECT_THAT(refused("3\n0\n-3\n1\n1 0.5"), HasSubstr("-3 components on 1 nodes"));
  EXPECT_THAT(refused("3\n0\n1\n99999\n1 0.5"), HasSubstr("99999 nodes do not fit"));
  EXPECT_THAT(refused("2\n0\n1\n1 0.5"), HasSubstr("2 integer tags"));
}

TEST(DamagedMshText, SectionsThatAreNotReadAreLeftOut) {
  const std::string whole = corpus("ascii22");
  EXPECT_EQ(refusal(replaced(whole, "$Nodes\n", "$Comments\nnothing $Nodes\n$EndComments\n$Nodes\n")),
            "accepted");
  EXPECT_THAT(refusal(whole + "$Periodic\n1\n"), HasSubstr("the section $Periodic has no $EndPeriodic"));
}

} // namespace
} // namespace drogue::mesh
