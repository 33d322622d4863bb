// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/mesh_pieces.hpp"

#include "tests/mpm_fem/bodies.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

TEST(MeshPieces, ABlockIsOne) {
  for (const test::Element element : test::kAllElements) {
    if (element == test::Element::kVoxel) continue;  // of grids, which know their pieces
    const Array<int32_t> piece = fem::mesh_pieces(test::block(element, 3, 2, 1, 1));
    for (int64_t n = 0; n < piece.rows(); ++n) EXPECT_EQ(piece(n), 0);
  }
}

/// Elements that share a node are joined, in any order of the elements.
TEST(MeshPieces, AreJoinedOverNodesAndNumberedByTheirFirst) {
  fem::ElementMesh mesh;
  mesh.element = fem::Element::kTet4;
  mesh.rest = Array<double>(14, 3);
  test::set_elements(mesh, {13, 12, 11, 10, 0, 2, 4, 6, 9, 8, 7, 11, 6, 1, 2, 0});
  const Array<int32_t> piece = fem::mesh_pieces(mesh);
  const int32_t wanted[14] = {0, 0, 0, -1, 0, -1, 0, 1, 1, 1, 1, 1, 1, 1};
  for (int64_t n = 0; n < 14; ++n) EXPECT_EQ(piece(n), wanted[n]) << n;
}

TEST(MeshPieces, OfNothingAreNone) {
  EXPECT_EQ(fem::mesh_pieces(fem::ElementMesh{}).rows(), 0);
}

}  // namespace
}  // namespace elastogen
