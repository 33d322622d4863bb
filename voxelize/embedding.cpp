// SPDX-License-Identifier: Apache-2.0
#include "voxelize/embedding.hpp"

#include "core/bricks/index.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "voxelize/embedding_impl.hpp"
#include "voxelize/nearest_voxel.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kCarried = 1;  ///< voxels along an axis over which an affine motion continues

/// Trilinear weights at t, in units of the voxel. Outside 0..1 they continue linearly from the
/// nearest point of the voxel, so that they still carry affine fields exactly.
void trilinear(const Vec3& t, double* weights) {
  Vec3 near;
  for (int d = 0; d < 3; ++d) near[d] = std::clamp(t[d], 0.0, 1.0);
  for (int c = 0; c < 8; ++c) {
    double factor[3];
    for (int d = 0; d < 3; ++d) factor[d] = c >> d & 1 ? near[d] : 1 - near[d];
    weights[c] = factor[0] * factor[1] * factor[2];
    for (int d = 0; d < 3; ++d)
      if (t[d] != near[d])
        weights[c] +=
            (c >> d & 1 ? 1 : -1) * factor[(d + 1) % 3] * factor[(d + 2) % 3] * (t[d] - near[d]);
  }
}

/// The point whose weights a point at t gets, in units of the voxel: t itself up to kCarried voxels
/// from the voxel, then closer and closer to the voxel, and the nearest point of the voxel from 2
/// kCarried.
Vec3 standing_for(const Vec3& t) {
  Vec3 near;
  double reach = 0;
  for (int d = 0; d < 3; ++d) {
    near[d] = std::clamp(t[d], 0.0, 1.0);
    reach = std::max(reach, std::abs(t[d] - near[d]));
  }
  if (reach <= kCarried) return t;
  const double share = std::max(2 * kCarried - reach, 0.0) / reach;
  for (int d = 0; d < 3; ++d) near[d] += share * (t[d] - near[d]);
  return near;
}

/// One tree for each part, or one for all voxels.
std::vector<NearestVoxel> trees_of(const VoxelGrid& grid) {
  std::vector<NearestVoxel> trees;
  for (size_t k = 0; k < std::max<size_t>(1, grid.part_shift.size()); ++k)
    trees.emplace_back(grid.voxel_coord, grid.part, int32_t(k));
  return trees;
}

}  // namespace

Embedding embed(const VoxelGrid& grid, In<double> points, In<int32_t> part) {
  // points, grid and parts must fit together
  ELASTOGEN_CHECK(points.cols == 3, "points must be (points, 3), got ", points);
  ELASTOGEN_CHECK(grid.voxel_count() > 0, "the grid has no voxels");
  ELASTOGEN_CHECK(grid.part.empty() || part.rows == points.rows, "each of ", points.rows,
                  " points must have a part, got ", part);
  for (int64_t i = 0; i < points.size(); ++i)
    ELASTOGEN_CHECK(std::isfinite(points.data[i]), "point ", i / 3, " is not finite");
  // voxels by coordinates, and trees for points that lie in none
  const BrickIndex index(grid.voxel_coord);
  const std::vector<NearestVoxel> nearest = trees_of(grid);
  Embedding embedding = {Array<int32_t>(points.rows), Array<double>(points.rows, 8)};
  for_each(points.rows, [&](int64_t p) {
    const auto k = size_t(grid.part.empty() ? 0 : part(p));
    const double shift = grid.part.empty() ? 0 : grid.part_shift[k];
    // lattice coordinates, moved to where the part's voxels are
    Vec3 t;
    Coord cell;
    bool on_lattice = true;
    for (int d = 0; d < 3; ++d) {
      t[d] = (points(p, d) - grid.origin[d]) / grid.h;
      on_lattice = on_lattice && std::abs(t[d] + shift) < kLatticeLimit;
      if (on_lattice) cell[d] = static_cast<int32_t>(std::floor(t[d]));
    }
    t[0] += shift;
    cell[0] += int32_t(shift);
    // the voxel that holds the point, else the nearest one of its part
    int64_t v = on_lattice ? index.find(cell) : -1;
    if (v < 0 || (!grid.part.empty() && grid.part(v) != part(p))) v = nearest[k].find(t);
    if (v < 0) return;  // a part that is held as a whole has none
    // weights in that voxel
    for (int d = 0; d < 3; ++d) t[d] -= grid.voxel_coord(v, d);
    embedding.voxel(p) = static_cast<int32_t>(v);
    trilinear(standing_for(t), embedding.weights.row(p));
  });
  return embedding;
}

Embedding embed(const VoxelGrid& grid, In<double> points) {
  return embed(grid, points, {});
}

void deform_asset(const VoxelGrid& grid, const Embedding& embedding, In<double> x,
                  Out<double> displacement) {
  const int64_t points = embedding.voxel.rows();
  ELASTOGEN_CHECK(x.is(grid.node_count(), 3), "x must be (nodes, 3), got ", x);
  ELASTOGEN_CHECK(displacement.is(points, 3), "displacement must be (points, 3), got ",
                  displacement);
  for_each(points, [&](int64_t p) {
    embedded_displacement(grid.corners.row(embedding.voxel(p)), embedding.weights.row(p), x.data,
                          grid.rest.data(), displacement.row(p));
  });
}

void deformation_gradient(const VoxelGrid& grid, const Embedding& embedding, In<double> x,
                          Out<double> gradient) {
  const int64_t points = embedding.voxel.rows();
  ELASTOGEN_CHECK(x.is(grid.node_count(), 3), "x must be (nodes, 3), got ", x);
  ELASTOGEN_CHECK(gradient.is(points, 9), "gradient must be (points, 9), got ", gradient);
  for_each(points, [&](int64_t p) {
    embedded_gradient(grid.corners.row(embedding.voxel(p)), embedding.weights.row(p), x.data,
                      grid.rest.data(), grid.h, gradient.row(p));
  });
}

}  // namespace elastogen
