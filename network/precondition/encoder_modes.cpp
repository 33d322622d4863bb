// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/encoder_modes.hpp"

#include "core/parallel.hpp"

#include <algorithm>
#include <numeric>

namespace elastogen {
namespace {

constexpr int kSmallestPiece = 64;  // nodes; multigrid alone serves smaller ones
constexpr size_t kMostPieces = 64;

}  // namespace

std::vector<std::vector<int32_t>> encoder_pieces(const VoxelGrid& grid) {
  const int64_t nodes = grid.node_count();
  std::vector<int32_t> size(size_t(grid.pieces)), order(size.size()), rank(size.size(), -1);
  if (grid.pieces == 1)
    size[0] = int32_t(nodes);
  else
    for (int64_t n = 0; n < nodes; ++n) ++size[size_t(grid.piece(n))];
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int32_t a, int32_t b) { return size[size_t(a)] > size[size_t(b)]; });
  size_t count = 0;
  while (count < std::min(order.size(), kMostPieces) &&
         size[size_t(order[count])] >= kSmallestPiece)
    ++count;
  for (size_t s = 0; s < count; ++s) rank[size_t(order[s])] = int32_t(s);
  return grouped(nodes, count, [&](int64_t n) { return rank[size_t(grid.piece(n))]; });
}

ModeShape mode_shape(const Box& box, const PlaneCosines& cosines) {
  ModeShape shape{cosines.tables(), {}, {}, 0};
  for (int d = 0; d < 3; ++d) {
    shape.lower[d] = box.lower[size_t(d)];
    shape.upper[d] = box.upper[size_t(d)];
    shape.size = std::max(shape.size, box.extent(d));
  }
  return shape;
}

}  // namespace elastogen
