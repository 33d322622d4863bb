// SPDX-License-Identifier: Apache-2.0
#include "io/stl_reader.hpp"

#include "io/asset_check.hpp"
#include "tests/io/test_files.hpp"

#include <cstring>

namespace elastogen {
namespace {

using test::error_of;
using test::expect_says;

Asset parsed_stl(std::string_view bytes) {
  return parse_stl(bytes, "file.stl");
}

/// A binary file of one facet a triple of positions (little-endian machines).
std::string binary(const std::string& header, uint32_t count, const std::vector<float>& numbers) {
  std::string out = header;
  out.resize(80, ' ');
  out.append(reinterpret_cast<const char*>(&count), 4);
  for (size_t k = 0; k < numbers.size(); k += 9) {
    out.append(12, '\0');
    out.append(reinterpret_cast<const char*>(&numbers[k]), 36);
    out.append(2, '\x11');
  }
  return out;
}

const std::vector<float> kTwoFacets = {0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0};
const std::vector<Vec3> kTwoPositions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0},
                                         {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};

constexpr const char* kStlText =
    "solid with  blanks and facet\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n"
    "   VERTEX 1e0 0 0\n   vertex 0 +1.0 0\n  endloop\n endfacet\nendsolid\r\n"
    "SOLID\nFACET NORMAL 0 0 1\nOUTER LOOP\nVERTEX 1 0 0\nVERTEX 1 1 0\nVERTEX 0 1 0\nENDLOOP\n"
    "ENDFACET\nENDSOLID\n";

TEST(StlReader, BinaryKeepsThreePositionsAFacet) {
  for (const char* header : {"", "solid but binary"}) {
    const Asset asset = parsed_stl(binary(header, 2, kTwoFacets));
    ASSERT_EQ(asset.meshes.size(), 1u);
    EXPECT_EQ(asset.meshes[0].position, kTwoPositions);
    EXPECT_EQ(asset.meshes[0].groups.at(0).corner, (std::vector<int32_t>{0, 1, 2, 3, 4, 5}));
  }
}

TEST(StlReader, TextMayHaveSeveralSolidsAndUpperCase) {
  const Asset asset = parsed_stl(kStlText);
  ASSERT_EQ(asset.nodes.size(), 2u);
  EXPECT_EQ(asset.nodes[0].name, "with  blanks and facet");
  EXPECT_EQ(asset.nodes[1].name, "file");  // without a name that of the file
  const Surface surface = pose_surface(asset);
  ASSERT_EQ(surface.vertices.rows(), 6);
  for (int64_t v = 0; v < 6; ++v)
    for (int d = 0; d < 3; ++d)
      EXPECT_EQ(surface.vertices(v, d), kTwoPositions[size_t(v)][size_t(d)]);
}

TEST(StlReader, SolidsOfOneNameAreOneNodeAndKeepTheirPlaceInTheFile) {
  std::string text;
  const char* names[] = {"Body", "Hat", "Body", ""};
  for (int k = 0; k < 4; ++k)
    text += concat("solid ", names[k], "\nfacet normal 0 0 1\nouter loop\nvertex ", k,
                   " 0 0\nvertex ", k, " 1 0\nvertex ", k, " 0 1\nendloop\nendfacet\nendsolid\n");
  const Asset asset = parsed_stl(text);
  ASSERT_EQ(asset.nodes.size(), 3u);
  for (size_t n = 0; n < 3; ++n) {
    EXPECT_EQ(asset.nodes[n].name, (std::array{"Body", "Hat", "file"}[n]));
    EXPECT_EQ(asset.nodes[n].mesh, int(n));
  }
  EXPECT_EQ(asset.meshes[0].position.size(), 6u);
  EXPECT_EQ(asset.meshes[0].file_position, (std::vector<int32_t>{0, 1, 2, 6, 7, 8}));
  EXPECT_EQ(asset.meshes[1].file_position, (std::vector<int32_t>{3, 4, 5}));
  EXPECT_EQ(repeated_positions(asset), 0);
  const Asset one = parsed_stl(text.substr(0, text.find("solid Hat")));
  EXPECT_EQ(one.nodes.at(0).name, "Body");
  EXPECT_TRUE(one.meshes[0].file_position.empty());
}

TEST(StlReader, RefusesWithThePlace) {
  const std::pair<std::string, std::string> cases[] = {
      {"", "84 bytes of a binary STL header are claimed but only 0 bytes are left"},
      {binary("", 3, kTwoFacets), "3 facets of a binary STL are claimed but only 100 bytes"},
      {binary("", 0xffffffffu, kTwoFacets), "4294967295 facets are too many"},
      {binary("solid but binary", 3, kTwoFacets), "3 facets of a binary STL are claimed"},
      {"solid\nfacet\nvertex 0 0 0\nvertex 0 0 0\nendfacet\n", "file.stl:5: a facet of 2 vertices"},
      {"solid\nfacet\nvertex 0 0 0\n", "the file ends within a facet"},
      {"solid\nfacet\nvertex 0 0\n", "file.stl:3: a number is expected, not \"\""},
      {"solid\nfacet\nvertex 0 0 zero\n", "file.stl:3: a number is expected, not \"zero\""},
      {"solid\nfacets\n", "file.stl:2: unknown keyword \"facets\""},
  };
  for (const auto& [bytes, message] : cases)
    expect_says(error_of([&, &b = bytes] { parsed_stl(b); }), message);
}

TEST(StlReader, AFileWithoutFacetsIsNothingToSimulate) {
  for (const std::string& bytes : {binary("", 0, {}), std::string("solid nothing\nendsolid\n")})
    expect_says(error_of([&] {
                  Asset asset = parsed_stl(bytes);
                  check_asset(asset);
                }),
                "nothing to simulate");
}

TEST(StlReader, AnyTruncationOfABinaryFileIsRefused) {
  const std::string bytes = binary("", 2, kTwoFacets);
  for (size_t n = 0; n < bytes.size(); ++n)
    EXPECT_FALSE(error_of([&] { parsed_stl(bytes.substr(0, n)); }).empty()) << n;
}

TEST(StlReader, AnyTruncationOfATextIsReadOrRefused) {
  const std::string text = kStlText;
  for (size_t n = 0; n < text.size(); ++n) {
    try {
      const std::vector<Vec3> position = parsed_stl(text.substr(0, n)).meshes[0].position;
      ASSERT_LE(position.size(), kTwoPositions.size());
      EXPECT_TRUE(std::equal(position.begin(), position.end(), kTwoPositions.begin())) << n;
    } catch (const Error& error) {
      EXPECT_EQ(error.kind(), ErrorKind::kAsset) << error.what();
    }
  }
}

TEST(StlReader, ReadsRealFilesWithTheirCounts) {
  const std::string folder = test::assets_folder();
  if (folder.empty()) return;
  struct Row {
    const char* name;
    int64_t triangles, welded;
    bool closed;
  };
  const Row rows[] = {{"spot_soup_mm.stl", 5856, 2930, true},
                      {"spot_zup.stl", 5856, 2930, true},
                      {"spot_ascii_long_names.stl", 1400, 1299, false},
                      {"multibody.stl", 32, 20, true},
                      {"busted.STL", 3878, 1941, true},
                      {"featuretype.STL", 3476, 1722, true},
                      {"soup.stl", 100, 300, false}};
  for (const Row& row : rows) {
    const Surface surface = pose_surface(read_stl(folder + "broken/" + row.name));
    EXPECT_EQ(surface.triangles.rows(), row.triangles) << row.name;
    EXPECT_EQ(surface.vertices.rows(), 3 * row.triangles) << row.name;
    const WeldedMesh w = weld(surface, 1e-7);  // the tolerance of the table
    EXPECT_EQ(w.vertices.rows(), row.welded) << row.name;
    EXPECT_EQ(w.closed(), row.closed) << row.name;
  }
}

}  // namespace
}  // namespace elastogen
