// SPDX-License-Identifier: Apache-2.0
#include "io/tets/tet_reader.hpp"
#include "tests/io/test_files.hpp"
#include "tests/io/tets/tet_files.hpp"

namespace elastogen::tets {
namespace {

using test::error_of, test::expect_says;

const std::string kHead = "# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\n";
const std::string kHead5 = "# vtk DataFile Version 5.1\ntitle\nASCII\nDATASET UNSTRUCTURED_GRID\n";
const std::string kPoints = "POINTS 4 double\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n";
const std::string kCells = "CELLS 1 5\n4 0 1 2 3\n";
const std::string kTypes = "CELL_TYPES 1\n10\n";

std::string vtk_message(const std::string& bytes) {
  return error_of([&] { parse_tets(bytes, "file"); });
}

TEST(VtkReader, RegionsAreAnArrayOfOneIntegerACell) {
  const std::string file = kHead + kPoints + kCells + kTypes + "CELL_DATA 1\n";
  const std::pair<std::string, int64_t> cases[] = {
      {"SCALARS material int 1\nLOOKUP_TABLE default\n5\n", 5},
      {"SCALARS material int\nLOOKUP_TABLE default\n5\n", 5},
      {"SCALARS other int\nLOOKUP_TABLE default\n5\nSCALARS region int 1\nLOOKUP_TABLE t\n-6\n",
       -6},
      {"FIELD f 2\nother 3 1 double\n1 nan 3\ngmsh:physical 1 1 long\n7\n", 7},
      {"SCALARS material double\nLOOKUP_TABLE default\n5\n", 0},
      {"SCALARS material int 2\nLOOKUP_TABLE default\n5 6\n", 0},
      {"VECTORS v double\n1 2 3\nSCALARS material int\nLOOKUP_TABLE default\n5\n", 0},
      {"", 0}};
  for (const auto& [data, region] : cases)
    EXPECT_EQ(parse_tets(file + data, "file").region_ids, std::vector<int64_t>{region}) << data;
}

TEST(VtkReader, RefusesBrokenText) {
  // head, sections, points, cells, types and data of cells, then offsets of version 5
  const std::pair<std::string, std::string> cases[] = {
      {"# vtk DataFile Version 6.0\n", "file:1: version \"6.0\" is not read"},
      {"# vtk DataFile Version x\n", "file:1: version \"x\" is not read"},
      {"# vtk DataFile\n", "file:1: version"},
      {"# vtk DataFile Version 3.0\ntitle\nTEXT\n", "file:3: ASCII or BINARY is expected"},
      {"# vtk DataFile Version 3.0\ntitle\nASCII\nDATASET POLYDATA\n",
       "file:4: unstructured_grid is expected, not \"POLYDATA\""},
      {kHead + "VERTICES 1\n", "file:5: POINTS, CELLS or CELL_TYPES should begin here"},
      {kHead + kPoints + kCells, "the file ends without CELL_TYPES"},
      {kHead + kPoints + kPoints, "file:10: a second list of points"},
      {kHead + kPoints + kCells + kCells, "file:12: a second list of cells"},
      {kHead + kPoints + kCells + kTypes + kTypes, "file:14: a second list of types"},
      {kHead + "POINTS 4 bit\n", "file:5: numbers of type \"bit\" are not read"},
      {kHead + "POINTS -4 double\n", "the number of points must be from 0 to 2147483646, not -4"},
      {kHead + "POINTS 2147483646 double\n0 0 0", "6442450938 numbers of points are claimed"},
      {kHead + "POINTS 1 double\n0 inf 0\n", "file:6: a coordinate of a point is not finite"},
      {kHead + "POINTS 2 double\n0 0 0 0 0\n", "the file ends where a coordinate of a point"},
      {kHead + kPoints + "CELLS 1 5\n4 0 1 2 4\n",
       "file:11: the point of a cell must be from 0 to 3, not 4"},
      {kHead + kPoints + "CELLS 1 5\n4 0 1 2 -1\n", "must be from 0 to 3, not -1"},
      {kHead + kPoints + "CELLS 1 5\n5 0 1 2 3\n", "the number of points of a cell must be from 0"},
      {kHead + kPoints + "CELLS 1 6\n4 0 1 2 3 0\n", "the cells end 1 integers too early"},
      {kHead + kPoints + "CELLS 2 5\n4 0 1 2 3\n",
       "file:12: the file ends where the number of poi"},
      {kHead + kPoints + "CELLS 1 2000000000\n4 0 1 2 3\n", "2000000000 numbers of cells are"},
      {kHead + kPoints + kCells + "CELL_TYPES 2000000000\n10\n", "2000000000 numbers of types"},
      {kHead + kPoints + kCells + "CELL_TYPES 2\n10 10\n",
       "it has 2 types of cells, but points of 1"},
      {kHead + kPoints + kCells + "CELL_TYPES 1\n10", "the file ends within its last line"},
      {kHead + kPoints + kCells + "CELL_TYPES 1\n12\n",
       "file: cell 0 (counted from 0) is of type 12 "
       "(a hexahedron)"},
      {kHead + kPoints + kCells + "CELL_TYPES 1\n42\n", "(a polyhedron)"},
      {kHead + kPoints + kCells + "CELL_TYPES 1\n99\n", "type 99 (unknown)"},
      {kHead + kPoints + "CELLS 1 4\n3 0 1 2\n" + kTypes,
       "cell 0 (counted from 0) is a tetrahedron of 4 points, but has 3"},
      {kHead + kPoints + kCells + kTypes + "CELL_DATA 2\n", "data of 2 cells, there are 1"},
      {kHead + kPoints + kCells + kTypes + "CELL_DATA 1\nSCALARS a int 9\nLOOKUP_TABLE t\n",
       "scalars have from 1 to 4 components"},
      {kHead + kPoints + kCells + kTypes + "CELL_DATA 1\nFIELD f 1\na 2000000000 2000000000 int\n",
       "4000000000000000000 numbers of an array are claimed"},
      {kHead5 + kPoints + "CELLS 2 4\n4 0 1 2 3\n", "file:11: offsets is expected, not \"4\""},
      {kHead5 + kPoints + "CELLS 2 4\nOFFSETS vtktypeint64\n1 4\n", "the first offset is not 0"},
      {kHead5 + kPoints + "CELLS 2 4\nOFFSETS vtktypeint64\n0 5\n",
       "an offset must be from 0 to 4"},
      {kHead5 + kPoints +
           "CELLS 3 4\nOFFSETS int\n0 4 0\nCONNECTIVITY int\n0 1 2 3\nCELL_TYPES 2\n"
           "10 10\n",
       "cell 1 (counted from 0) ends at point 0 of 4 and begins at 4"},
      {kHead5 + kPoints + "CELLS 2 5\nOFFSETS int\n0 4\nCONNECTIVITY int\n0 1 2 3 0\n" + kTypes,
       "its cells have 4 points, but 5 are listed"},
      {kHead5 + kPoints + "CELLS 2 2000000000\nOFFSETS int\n0 4\nCONNECTIVITY int\n0 1 2 3\n",
       "2000000000 numbers of points of cells are claimed"}};
  for (const auto& [bytes, message] : cases) expect_says(vtk_message(bytes), message);
}

TEST(VtkReader, RefusesBrokenBytesWithTheirPlace) {
  const std::string file = test::vtk_file(test::two_tets(), true, 3);
  const size_t points = file.find("float\n") + 6;
  std::string changed = file;
  changed.replace(points + 8, 4, "\x7f\xc0\0\0", 4);
  expect_says(vtk_message(changed),
              "file: byte " + std::to_string(points + 8) + ": a coordinate of a point is not");
  const size_t cells = file.find("CELLS 3 14\n") + 11;
  changed = file;
  changed.replace(cells + 4, 4, "\0\0\0\6", 4);
  expect_says(vtk_message(changed), "file: byte " + std::to_string(cells + 4) +
                                        ": the point of a cell must be from 0 to 5, not 6");
}

}  // namespace
}  // namespace elastogen::tets
