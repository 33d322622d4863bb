// SPDX-License-Identifier: Apache-2.0
#include "io/tets/tet_reader.hpp"

#include "tests/io/test_files.hpp"
#include "tests/io/tets/tet_checks.hpp"
#include "tests/io/tets/tet_files.hpp"

#include <cmath>

namespace elastogen::tets {
namespace {

using test::all_files, test::error_of, test::expect_says, test::NamedFile, test::quadratic_tet,
    test::two_tets;

template <class T>
std::vector<T> values_of(const Array<T>& array) {
  return {array.data(), array.data() + array.size()};
}

/// Whether it is the mesh of test::two_tets, with any regions.
bool is_two_tets(const TetFile& file) {
  return file.elements.cols() == 4 &&
         values_of(file.rest) ==
             std::vector<double>{0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 1, 1, 1.5} &&
         values_of(file.elements) == std::vector<int32_t>{0, 1, 2, 3, 2, 1, 4, 3} &&
         file.turned == 1 && file.skipped == 1 && file.unused == 1;
}

TEST(TetReader, ReadsTheSameMeshFromEveryFormatAndEncoding) {
  for (const NamedFile& f : all_files(two_tets())) {
    const TetFile file = parse_tets(f.bytes, f.name);
    EXPECT_TRUE(is_two_tets(file)) << f.name;
    EXPECT_EQ(values_of(file.region), (std::vector<int32_t>{1, 0})) << f.name;
    EXPECT_EQ(file.region_ids, (std::vector<int64_t>{7, 9})) << f.name;
    EXPECT_GT(test::determinants(file).least, 0);
  }
}

TEST(TetReader, QuadraticTetrahedraHaveTheirNodesInTheMiddleOfTheirEdges) {
  constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  for (const bool turned : {false, true})
    for (const NamedFile& f : all_files(quadratic_tet(turned))) {
      const TetFile file = parse_tets(f.bytes, f.name);
      ASSERT_EQ(file.elements.cols(), 10) << f.name;
      ASSERT_EQ(file.elements.rows(), 1);
      EXPECT_EQ(file.turned, turned);
      EXPECT_EQ(test::tet_determinant(file, 0), 2 * 4 * 8);
      for (int k = 0; k < 6; ++k)
        for (int d = 0; d < 3; ++d)
          EXPECT_EQ(2 * file.rest(file.elements(0, 4 + k), d),
                    file.rest(file.elements(0, kEdges[k][0]), d) +
                        file.rest(file.elements(0, kEdges[k][1]), d))
              << f.name << ' ' << k;
    }
}

TEST(TetReader, TrianglesInThePlaneAreTheElementsWhereThereAreNoTetrahedra) {
  const test::TetCells plane{{{0, 0, 0}, {1, 0, 0}, {9, 9, 9}, {1, 1, 0}, {0, 1, 0}},
                             {{0, 1, 3}, {0, 4, 3}, {0, 1}},
                             {5, 5, 3},
                             {9, 7, 7}};
  for (const NamedFile& f : all_files(plane)) {
    const TetFile file = parse_tets(f.bytes, f.name);
    EXPECT_EQ(file.elements.cols(), 3);
    // the second one counterclockwise
    EXPECT_EQ(values_of(file.elements), (std::vector<int32_t>{0, 1, 2, 0, 2, 3})) << f.name;
    EXPECT_EQ(values_of(file.region), (std::vector<int32_t>{1, 0})) << f.name;
    EXPECT_EQ(file.turned, 1) << f.name;
    EXPECT_EQ(file.skipped, 1) << f.name;
    EXPECT_EQ(file.unused, 1) << f.name;
  }
}

TEST(TetReader, ReadsTextWithMarkAndCrlf) {
  for (const NamedFile& f : all_files(two_tets())) {
    if (f.name != "msh 2.2" && f.name != "msh 4.1" && f.name != "vtk 3" && f.name != "vtk 5" &&
        f.name != "vtu ascii")
      continue;
    std::string text = "\xef\xbb\xbf";
    for (const char c : f.bytes) text += c == '\n' ? "\r\n" : std::string(1, c);
    EXPECT_TRUE(is_two_tets(parse_tets(text, f.name))) << f.name;
  }
}

TEST(TetReader, FilesAreReadByTheirBytesNotTheirNames) {
  const test::TempFolder folder;
  const std::string path = folder.write("a.txt", test::msh2_file(two_tets(), true));
  EXPECT_TRUE(is_two_tets(read_tets(path)));
  expect_says(error_of([&] { read_tets(folder.path("none.msh")); }), "none.msh: No such file");
}

/// The mesh that the bytes hold, or nothing where they are refused; nothing else may happen.
std::optional<TetFile> read_or_refused(const std::string& bytes) {
  try {
    return parse_tets(bytes, "file");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kAsset) << error.what();
    EXPECT_TRUE(std::string(error.what()).starts_with("file:")) << error.what();
    return {};
  }
}

TEST(TetReader, ACutFileIsRefusedOrHasTheWholeMesh) {
  for (const NamedFile& f : all_files(two_tets()))
    for (size_t n = 0; n < f.bytes.size(); ++n) {
      const std::optional<TetFile> file = read_or_refused(f.bytes.substr(0, n));
      EXPECT_TRUE(!file || is_two_tets(*file)) << f.name << ": " << n << " of " << f.bytes.size();
      EXPECT_TRUE(!file || n > f.bytes.size() / 2);
    }
}

TEST(TetReader, AnyByteIsReadOrRefused) {
  for (const auto& mesh : {two_tets(), quadratic_tet(true)})
    for (const NamedFile& f : all_files(mesh))
      for (size_t n = 0; n < f.bytes.size(); ++n)
        for (const unsigned char value : {0, 0x39, 0x3c, 0xff}) {
          std::string changed = f.bytes;
          changed[n] = char(value);
          const std::optional<TetFile> file = read_or_refused(changed);
          if (!file) continue;
          for (int64_t k = 0; k < file->elements.size(); ++k)
            ASSERT_LT(uint32_t(file->elements.data()[k]), file->rest.rows());
          ASSERT_GT(test::determinants(*file).least, 0);
        }
}

TEST(TetReader, RefusesOtherFilesAndMeshes) {
  const std::pair<std::string, std::string> cases[] = {
      {"", "file: begins neither like a Gmsh MSH nor like a VTK or VTU file"},
      {"ply\nformat ascii 1.0\n", "begins neither"},
      {"# vtk\n", "begins neither"}};
  for (const auto& [bytes, message] : cases)
    expect_says(error_of([&] { parse_tets(bytes, "file"); }), message);

  // flat tetrahedra
  test::TetCells mesh;
  for (const double height : {0., 1e-15, -1e-15, 1e-300}) {
    mesh = two_tets();
    mesh.points[4] = {0.5, 0.5, height};
    for (const NamedFile& f : all_files(mesh))
      expect_says(error_of([&] { parse_tets(f.bytes, f.name); }),
                  ": tetrahedron 0 (counted from 0) is flat");
  }
  // mixed orders and other cells
  mesh = quadratic_tet(false);
  mesh.cells.push_back({0, 1, 2, 3});
  mesh.types.push_back(10);
  mesh.regions.push_back(3);
  for (const NamedFile& f : all_files(mesh))
    expect_says(error_of([&] { parse_tets(f.bytes, f.name); }), "both linear and quadratic");
  mesh = two_tets();
  mesh.cells.push_back({0, 1, 2, 3, 4, 5, 0, 1});
  mesh.types.push_back(12);
  mesh.regions.push_back(3);
  for (const NamedFile& f : all_files(mesh))
    expect_says(error_of([&] { parse_tets(f.bytes, f.name); }), "(a hexahedron)");
}

TEST(TetReader, RefusesTrianglesOutOfThePlaneAndFlatOnes) {
  test::TetCells mesh = two_tets();
  mesh.cells.resize(1);
  mesh.types.resize(1);
  mesh.regions.resize(1);
  mesh.points[2][2] = 1e-3;
  for (const NamedFile& f : all_files(mesh))
    expect_says(
        error_of([&] { parse_tets(f.bytes, f.name); }),
        ": it has no tetrahedra, and triangle 0 (counted from 0) does not lie in the plane");
  mesh.points[2] = {2, 0, 0};
  for (const NamedFile& f : all_files(mesh))
    expect_says(error_of([&] { parse_tets(f.bytes, f.name); }),
                ": triangle 0 (counted from 0) has");
  mesh.cells = {{0, 1}};
  mesh.types = {3};
  for (const NamedFile& f : all_files(mesh))
    expect_says(error_of([&] { parse_tets(f.bytes, f.name); }), ": it has no tetrahedra, nor");
}

TEST(TetReader, RefusesCoordinatesThatAreNotFinite) {
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    test::TetCells mesh = two_tets();
    mesh.points[3][1] = bad;  // also of a point that nothing uses
    for (const NamedFile& f : all_files(mesh))
      expect_says(error_of([&] { parse_tets(f.bytes, f.name); }), "is not finite");
  }
  expect_says(error_of([&] {
                test::TetCells mesh = two_tets();
                mesh.points[3][1] = std::nan("");
                parse_tets(test::msh2_file(mesh, false), "file");
              }),
              "file:13: a coordinate of a node is not finite");
}

TEST(TetReader, ReadsARealFile) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) GTEST_SKIP();
  const TetFile file = read_tets(folder + "closed/bunny_tets.msh");
  EXPECT_EQ(file.elements.rows(), 19379);
  EXPECT_EQ(file.rest.rows(), 4670);
  EXPECT_EQ(file.unused, 0);
  Box box;
  for (int32_t n = 0; n < 4670; ++n) box.add(test::place(file.rest, n));
  EXPECT_NEAR(box.extent(0), 3.11, 5e-3);
  EXPECT_NEAR(box.extent(1), 3.08, 5e-3);
  EXPECT_NEAR(box.extent(2), 2.42, 5e-3);
  const test::Faces faces = test::faces(file);
  EXPECT_EQ(faces.wrong, 0);
  EXPECT_EQ(2 * faces.inner + faces.border, 4 * 19379);
}

}  // namespace
}  // namespace elastogen::tets
