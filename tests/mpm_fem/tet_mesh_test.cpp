// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/tet_mesh.hpp"

#include <gtest/gtest.h>

#include <numeric>

namespace elastogen::fem {
namespace {

/// One tetrahedron of so many nodes, all different.
tets::TetFile file_of(int nodes) {
  tets::TetFile file;
  file.rest = Array<double>(nodes, 3);
  std::iota(file.rest.data(), file.rest.data() + file.rest.size(), 0.5);
  file.elements = Array<int32_t>(1, nodes);
  std::iota(file.elements.data(), file.elements.data() + nodes, 0);
  return file;
}

TEST(TetMesh, TheNodesOfATetrahedronTellTheElement) {
  for (const int nodes : {4, 10}) {
    tets::TetFile file = file_of(nodes);
    const ElementMesh mesh = take_mesh(file);
    EXPECT_EQ(mesh.element, nodes == 4 ? Element::kTet4 : Element::kTet10);
    EXPECT_EQ(mesh.rest, file_of(nodes).rest);
    EXPECT_EQ(mesh.elements, file_of(nodes).elements);
    EXPECT_EQ(mesh.material, Array<int32_t>(1));
  }
}

}  // namespace
}  // namespace elastogen::fem
