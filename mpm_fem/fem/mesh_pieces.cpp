// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/mesh_pieces.hpp"

#include <algorithm>
#include <numeric>
#include <vector>

namespace elastogen::fem {
namespace {

/// The first node of a node's piece; halves the path to it for the next search.
int32_t root_of(std::vector<int32_t>& parent, int32_t node) {
  while (parent[size_t(node)] != node) {
    parent[size_t(node)] = parent[size_t(parent[size_t(node)])];
    node = parent[size_t(node)];
  }
  return node;
}

}  // namespace

Array<int32_t> mesh_pieces(const ElementMesh& mesh) {
  const int64_t nodes = mesh.rest.rows();
  std::vector<int32_t> parent(static_cast<size_t>(nodes));
  std::iota(parent.begin(), parent.end(), 0);
  std::vector<uint8_t> used(static_cast<size_t>(nodes));
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    for (int64_t c = 0; c < mesh.elements.cols(); ++c) {
      used[size_t(mesh.elements(e, c))] = 1;
      const auto [first, second] =
          std::minmax({root_of(parent, mesh.elements(e, 0)), root_of(parent, mesh.elements(e, c))});
      parent[size_t(second)] = first;
    }
  Array<int32_t> piece(nodes);
  int32_t count = 0;
  for (int32_t n = 0; n < nodes; ++n) {
    const int32_t root = root_of(parent, n);  // a root is the least node of its piece
    piece(n) = !used[size_t(n)] ? -1 : root == n ? count++ : piece(root);
  }
  return piece;
}

}  // namespace elastogen::fem
