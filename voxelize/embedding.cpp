// SPDX-License-Identifier: Apache-2.0
#include "voxelize/embedding.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "voxelize/brick_index.hpp"
#include "voxelize/nearest_voxel.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

/// Trilinear weights at t in units of the voxel; outside of 0..1 they go on linearly from the
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

/// Gradients of trilinear's weights with respect to t. A coordinate within 0..1 also moves the
/// nearest point, and with it the slopes by which the other coordinates go on.
void trilinear_gradient(const Vec3& t, double gradient[8][3]) {
  Vec3 near;
  for (int d = 0; d < 3; ++d) near[d] = std::clamp(t[d], 0.0, 1.0);
  for (int c = 0; c < 8; ++c) {
    double factor[3], sign[3];
    for (int d = 0; d < 3; ++d) {
      factor[d] = c >> d & 1 ? near[d] : 1 - near[d];
      sign[d] = c >> d & 1 ? 1 : -1;
    }
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      gradient[c][d] = sign[d] * factor[e] * factor[f];
      if (t[d] != near[d]) continue;
      gradient[c][d] += sign[d] * (sign[e] * factor[f] * (t[e] - near[e]) +
                                   sign[f] * factor[e] * (t[f] - near[f]));
    }
  }
}

}  // namespace

Embedding embed(const VoxelGrid& grid, In<double> points) {
  ELASTOGEN_CHECK(points.cols == 3, "points must be (points, 3), got ", points);
  ELASTOGEN_CHECK(grid.voxel_count() > 0, "the grid has no voxels");
  for (int64_t i = 0; i < points.size(); ++i)
    ELASTOGEN_CHECK(std::isfinite(points.data[i]), "point ", i / 3, " is not finite");
  const BrickIndex index(grid.voxel_coord);
  const NearestVoxel nearest(grid.voxel_coord);
  Embedding embedding = {Array<int32_t>(points.rows), Array<double>(points.rows, 8)};
  for_each(points.rows, [&](int64_t p) {
    Vec3 t;
    Coord cell;
    bool on_lattice = true;
    for (int d = 0; d < 3; ++d) {
      t[d] = (points(p, d) - grid.origin[d]) / grid.h;
      on_lattice = on_lattice && std::abs(t[d]) < kLatticeLimit;
      if (on_lattice) cell[d] = static_cast<int32_t>(std::floor(t[d]));
    }
    int64_t v = on_lattice ? index.find(cell) : -1;
    if (v < 0) v = nearest.find(t);
    for (int d = 0; d < 3; ++d) t[d] -= grid.voxel_coord(v, d);
    embedding.voxel(p) = static_cast<int32_t>(v);
    trilinear(t, embedding.weights.row(p));
  });
  return embedding;
}

void deform_asset(const VoxelGrid& grid, const Embedding& embedding, In<double> x,
                  Out<double> displacement) {
  const int64_t points = embedding.voxel.rows();
  ELASTOGEN_CHECK(x.is(grid.node_count(), 3), "x must be (nodes, 3), got ", x);
  ELASTOGEN_CHECK(displacement.is(points, 3), "displacement must be (points, 3), got ",
                  displacement);
  for_each(points, [&](int64_t p) {
    double sum[3] = {};
    for (int c = 0; c < 8; ++c) {
      const int32_t node = grid.corners(embedding.voxel(p), c);
      for (int d = 0; d < 3; ++d)
        sum[d] += embedding.weights(p, c) * (x(node, d) - grid.rest(node, d));
    }
    std::copy(sum, sum + 3, displacement.row(p));
  });
}

void deformation_gradient(const VoxelGrid& grid, const Embedding& embedding, In<double> x,
                          Out<double> gradient) {
  const int64_t points = embedding.voxel.rows();
  ELASTOGEN_CHECK(x.is(grid.node_count(), 3), "x must be (nodes, 3), got ", x);
  ELASTOGEN_CHECK(gradient.is(points, 9), "gradient must be (points, 9), got ", gradient);
  for_each(points, [&](int64_t p) {
    // the weights carry linear functions exactly, hence the point's own place
    Vec3 t = {};
    for (int c = 0; c < 8; ++c)
      for (int d = 0; d < 3; ++d) t[d] += (c >> d & 1) * embedding.weights(p, c);
    double slope[8][3];
    trilinear_gradient(t, slope);
    double F[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
    for (int c = 0; c < 8; ++c) {
      const int32_t node = grid.corners(embedding.voxel(p), c);
      for (int i = 0; i < 3; ++i)
        for (int d = 0; d < 3; ++d)
          F[3 * i + d] += (x(node, i) - grid.rest(node, i)) * slope[c][d] / grid.h;
    }
    std::copy(F, F + 9, gradient.row(p));
  });
}

}  // namespace elastogen
