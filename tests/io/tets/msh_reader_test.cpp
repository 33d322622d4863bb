// SPDX-License-Identifier: Apache-2.0
#include "io/tets/tet_reader.hpp"
#include "tests/io/test_files.hpp"
#include "tests/io/tets/tet_files.hpp"

namespace elastogen::tets {
namespace {

using test::error_of, test::expect_says;

const std::string kFormat2 = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n";
const std::string kNodes2 = "$Nodes\n4\n1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n$EndNodes\n";
const std::string kFormat4 = "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n";
const std::string kNodes4 =
    "$Nodes\n1 4 1 4\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n";

/// Elements of MSH 2 from their lines.
std::string elements2(const std::string& count, const std::string& lines) {
  return "$Elements\n" + count + '\n' + lines + "$EndElements\n";
}

std::string msh_message(const std::string& bytes) {
  return error_of([&] { parse_tets(bytes, "file"); });
}

TEST(MshReader, RegionsAreTheFirstPhysicalGroupElseTheEntity) {
  const TetFile file = parse_tets(
      kFormat2 + kNodes2 +
          elements2("5",
                    "1 4 3 8 5 1 1 2 3 4\n2 4 2 0 6 1 2 3 4\n3 4 1 3 1 2 3 4\n4 4 0 1 2 3 4\n"
                    "5 4 4 -2 6 2 1 1 2 3 4\n"),
      "file");
  EXPECT_EQ(file.region_ids, (std::vector<int64_t>{-2, 0, 3, 6, 8}));
  const int32_t expected[] = {4, 3, 2, 1, 0};
  for (int64_t e = 0; e < 5; ++e) EXPECT_EQ(file.region(e), expected[e]);
}

TEST(MshReader, LeavesOutSectionsThatItDoesNotKnow) {
  const std::string other = "$Periodic\n0 $Nodes 1\n$EndPeriodic\n";
  const TetFile file =
      parse_tets("$Comments\nmade by a test\n$EndComments\n" + kFormat4 + other + kNodes4 + other +
                     "$Elements\n1 1 1 1\n3 1 4 1\n7 1 2 3 4\n$EndElements\n" +
                     "$NodeData\n1\n\"T\"\n$EndNodeData",
                 "file");
  EXPECT_EQ(file.elements.rows(), 1);
  EXPECT_EQ(file.region_ids, std::vector<int64_t>{1});
}

TEST(MshReader, RefusesBrokenText) {
  const std::string one = elements2("1", "1 4 2 0 1 1 2 3 4\n");
  // sections, then nodes and elements of version 2.2, then blocks of version 4.1
  const std::pair<std::string, std::string> cases[] = {
      {"$MeshFormat\n4.0 0 8\n", "file:2: version \"4.0\" is not read; save it as 4.1 or 2.2"},
      {"$MeshFormat\n2.2 2 8\n", "file:2: the kind of file must be from 0 to 1"},
      {"$MeshFormat\n2.2 1 4\n", "file:2: numbers of 8 bytes are expected, not of 4"},
      {"$MeshFormat\n2.2 0 8\nmore", "file:3: $EndMeshFormat is expected, not \"more\""},
      {kFormat2 + kFormat2, "file:4: a second $MeshFormat"},
      {kNodes2, "file:1: a second $Nodes, or one before $MeshFormat"},
      {kFormat2 + one, "file:4: a second $Elements, or one before $Nodes"},
      {kFormat2 + kNodes2 + kNodes2, "file:11: a second $Nodes"},
      {kFormat2 + kNodes2 + one + one, "file:15: a second $Elements"},
      {kFormat2 + kNodes2, "file:11: the file ends without $Elements"},
      {kFormat2 + "1 2 3", "file:4: a section should begin, not \"1\""},
      {kFormat2 + "$Other\n1\n", "file:4: the file ends before $EndOther"},
      {kFormat2 + "$Nodes\n2\n1 0 0 0\n1 1 0 0\n$EndNodes\n", "the node 1 is there twice"},
      {kFormat2 + "$Nodes\n1\n1 0 nan 0\n$EndNodes\n", "file:6: a coordinate of a node is not"},
      {kFormat2 + "$Nodes\n1\n1 0 1e999 0\n$EndNodes\n", "file:6: a coordinate of a node is not"},
      {kFormat2 + "$Nodes\n1\n1 0 x 0\n$EndNodes\n", "must be a number, not \"x\""},
      {kFormat2 + "$Nodes\n-1\n", "file:5: -1 numbers of nodes are claimed"},
      {kFormat2 + "$Nodes\n4000000000000000000\n1 0 0 0\n",
       "are claimed but only 9 bytes are left"},
      {kFormat2 + "$Nodes\n99999999999999999999\n", "the number of nodes must be an integer"},
      {kFormat2 + "$Nodes\n1\n1 0 0 0\n2 0 0 0\n$EndNodes\n", "file:7: $EndNodes is expected"},
      {kFormat2 + kNodes2 + elements2("9000000000", ""), "9000000000 numbers of elements are"},
      {kFormat2 + kNodes2 + elements2("1", "1 5 2 0 1 1 2 3 4\n"),
       "file:13: elements of type 5 (a hexahedron) are not read"},
      {kFormat2 + kNodes2 + elements2("1", "1 6 2 0 1 1 2 3 4\n"), "(a prism)"},
      {kFormat2 + kNodes2 + elements2("1", "1 7 2 0 1 1 2 3 4\n"), "(a pyramid)"},
      {kFormat2 + kNodes2 + elements2("1", "1 29 2 0 1 1 2 3 4\n"), "of higher order"},
      {kFormat2 + kNodes2 + elements2("1", "1 -4 2 0 1 1 2 3 4\n"), "type -4 (unknown)"},
      {kFormat2 + kNodes2 + elements2("1", "1 4 2 0 1 1 2 3 5\n"),
       "file:13: a tetrahedron has the node 5, which is not there"},
      {kFormat2 + kNodes2 + elements2("1", "1 4 2 0 1 1 2 3 -1\n"), "has the node -1"},
      {kFormat2 + kNodes2 + elements2("1", "1 4 -1 1 2 3 4\n"), "-1 numbers of tags are claimed"},
      {kFormat2 + kNodes2 + elements2("1", "1 4 70000000000 1 2 3 4\n"), "numbers of tags are"},
      {kFormat2 + kNodes2 + elements2("2", "1 4 0 1 2 3 4\n"), "must be an integer, not \"$EndE"},
      {kFormat4 + "$Nodes\n1 4 1 4\n4 1 0 4\n", "file:6: the dimension of a block must be from"},
      {kFormat4 + "$Nodes\n1 4 1 4\n3 1 2 4\n", "whether a block has parameters must be from 0"},
      {kFormat4 + "$Nodes\n1 4 1 4\n3 1 0 4000000000000000000\n1\n", "but only 3 bytes are left"},
      {kFormat4 + "$Entities\n0 0 0 5000000000\n", "5000000000 numbers of entities are claimed"},
      {kFormat4 + "$Entities\n1 0 0 0\n1 0 0 0 -3\n", "-3 numbers of physical groups are"},
      {kFormat4 + "$Entities\n0 1 0 0\n1 0 0 0 1 1 1 0 1000\n", "numbers of borders of an entity"},
      {kFormat4 + kNodes4 + "$Elements\n1 1 1 1\n3 1 4 7000000000\n", "7000000000 numbers of ele"},
      {kFormat4 + kNodes4 + "$Elements\n1 1 1 1\n3 1 5 1\n7 1 2 3 4\n", "(a hexahedron)"},
      {kFormat4 + kNodes4 + "$Elements\n1 1 1 1\n3 1 4 1\n7 1 2 3 5\n", "has the node 5"}};
  for (const auto& [bytes, message] : cases) expect_says(msh_message(bytes), message);
}

TEST(MshReader, RefusesBrokenBytesWithTheirPlace) {
  const std::string file = test::msh2_file(test::two_tets(), true);
  // the number 1 in the other order begins a file in the other order, any other number none
  std::string changed = file;
  changed[file.find("8\n") + 2] = 2;
  expect_says(msh_message(changed), "file: byte 20: the number 1 is expected");

  const size_t nodes = file.find("$Nodes\n6\n") + 9;
  changed = file;
  changed.replace(nodes + 4, 8, "\0\0\0\0\0\0\xf0\x7f", 8);
  expect_says(msh_message(changed), "a coordinate of a node is not finite");
  expect_says(msh_message(changed), "file: byte " + std::to_string(nodes + 4));

  const size_t elements = file.find("$Elements\n3\n") + 12;
  changed = file;
  changed.replace(elements + 4, 4, "\x7f\xff\xff\x7f", 4);  // elements of the first block
  expect_says(msh_message(changed), "the size of a block must be from 0 to 3");
  changed = file;
  changed.replace(elements + 8, 4, "\xff\xff\xff\x7f", 4);  // tags of each
  expect_says(msh_message(changed), "2147483647 numbers of tags are claimed");
}

}  // namespace
}  // namespace elastogen::tets
