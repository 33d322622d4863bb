// SPDX-License-Identifier: Apache-2.0
// Tractions against resultants of the exact load, and against the nodal forces of uniform stress.

#include "mpm_fem/fem/surface_load.hpp"

#include "core/error.hpp"
#include "tests/mpm_fem/bodies.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using fem::surface_load;
using test::Element;
using test::ElementMesh;

constexpr int kSize[3] = {3, 2, 4};
constexpr double kH = 0.1;
const Vec3 kForce = {3, -5, 7};

/// The box [0, 0.3] x [0, 0.2] x [0, 0.4]: voxels, or tetrahedra with inner nodes moved.
ElementMesh box_mesh(Element element) {
  if (fem::nodes_of(element) == 8)
    return fem::voxel_mesh(
        test::voxel_scene(make_box(kSize[0], kSize[1], kSize[2], kH), test::solid()), element);
  return test::block(element, kSize[0], kSize[1], kSize[2], kH, 0.25);
}

/// Nodes with a coordinate of at least `least`.
Array<uint8_t> beyond(const ElementMesh& mesh, int axis, double least) {
  Array<uint8_t> selected(mesh.rest.rows());
  for (int64_t n = 0; n < selected.rows(); ++n) selected(n) = mesh.rest(n, axis) > least - 1e-9;
  return selected;
}

/// sum_n X_i f_d of a load; without i the resultant.
double moment(const ElementMesh& mesh, const Array<double>& load, int d, int i = -1) {
  double sum = 0;
  for (int64_t n = 0; n < load.rows(); ++n) sum += (i < 0 ? 1 : mesh.rest(n, i)) * load(n, d);
  return sum;
}

TEST(SurfaceLoad, HasTheForceAndTheMomentsOfAnEvenLoadOnAFace) {
  for (const Element element : test::kAllElements) {
    const ElementMesh mesh = box_mesh(element);
    const Vec3 lower = test::rest_of(mesh, 0);
    for (int axis = 0; axis < 3; ++axis) {
      const double end = lower[size_t(axis)] + kSize[axis] * kH;
      const Array<double> load = surface_load(mesh, beyond(mesh, axis, end), kForce);
      ASSERT_EQ(load.rows(), mesh.rest.rows());
      for (int d = 0; d < 3; ++d) {
        EXPECT_NEAR(moment(mesh, load, d), kForce[size_t(d)], 1e-13);
        for (int i = 0; i < 3; ++i) {
          const double centre = i == axis ? end : lower[size_t(i)] + kSize[i] * kH / 2;
          EXPECT_NEAR(moment(mesh, load, d, i), kForce[size_t(d)] * centre, 1e-13);
        }
      }
      for (int64_t n = 0; n < load.rows(); ++n)
        if (mesh.rest(n, axis) < end - 1e-9) {
          EXPECT_EQ(load(n, 0), 0);
        }
    }
  }
}

/// All nodes selected: the whole boundary, no inner face. The mean of the position over the six
/// sides of a box is its centre.
TEST(SurfaceLoad, LeavesInnerFacesOut) {
  for (const Element element : test::kAllElements) {
    const ElementMesh mesh = box_mesh(element);
    const Array<double> load = surface_load(mesh, beyond(mesh, 0, -1e9), {1, 0, 0});
    int64_t inner = 0;
    for (int64_t n = 0; n < load.rows(); ++n) {
      bool inside = true;
      for (int d = 0; d < 3; ++d) {
        const double at = mesh.rest(n, d) - mesh.rest(0, d);
        inside &= at > 1e-9 && at < kSize[d] * kH - 1e-9;
      }
      inner += inside;
      if (inside) {
        EXPECT_EQ(load(n, 0), 0);
      }
    }
    EXPECT_GT(inner, 0);
    for (int d = 0; d < 3; ++d)
      EXPECT_NEAR(moment(mesh, load, 0, d), mesh.rest(0, d) + kSize[d] * kH / 2, 1e-13);
  }
}

/// Forces that hold a uniform stress in a column of partly filled voxels are the load on its end.
TEST(SurfaceLoad, IsThatOfAUniformStressInPartlyFilledVoxels) {
  VoxelGrid grid = make_box(2, 2, 2, kH);
  test::Random random(3);
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    // filled alike along x, off the middle across it
    const int y = grid.voxel_coord(v, 1), z = grid.voxel_coord(v, 2);
    grid.fill(v) = 0.3 + 0.2 * y + 0.1 * z;
    const double place[3] = {0.5, 0.3 + 0.1 * y, 0.6 - 0.2 * z};
    for (int c = 0; c < 8; ++c) {
      grid.shape_mean(v, c) = 1;
      for (int d = 0; d < 3; ++d) grid.shape_mean(v, c) *= c >> d & 1 ? place[d] : 1 - place[d];
    }
  }
  const Material material = test::solid(Law::kNeoHookean, 1, 0);
  const Scene scene = test::voxel_scene(grid, material, Hourglass::kFull);
  for (const Element element : {Element::kVoxel, Element::kHex}) {
    const ElementMesh mesh = fem::voxel_mesh(scene, element);
    const fem::ElasticBody body(mesh, {material});
    Array<double> u(mesh.rest.rows(), 3), hold(mesh.rest.rows(), 3);
    for (int64_t n = 0; n < u.rows(); ++n) u(n, 0) = 0.2 * mesh.rest(n, 0);
    body.add_gradient(u, hold);
    const Array<uint8_t> end = beyond(mesh, 0, test::rest_of(mesh, 0)[0] + 2 * kH);
    double force = 0;
    for (int64_t n = 0; n < u.rows(); ++n) force += end(n) * hold(n, 0);
    EXPECT_GT(force, 1e-4);
    const Array<double> load = surface_load(mesh, end, {force, 0, 0});
    for (int64_t n = 0; n < u.rows(); ++n)
      if (end(n)) {
        EXPECT_NEAR(load(n, 0), hold(n, 0), 1e-14 * force) << n;
      }
  }
}

TEST(SurfaceLoad, IsEmptyWithoutAFace) {
  for (const Element element : test::kAllElements) {
    const ElementMesh mesh = box_mesh(element);
    Array<uint8_t> selected(mesh.rest.rows());
    EXPECT_TRUE(surface_load(mesh, selected, kForce).empty());
    selected(0) = 1;
    EXPECT_TRUE(surface_load(mesh, selected, kForce).empty());
    EXPECT_THROW(surface_load(mesh, Array<uint8_t>(3), kForce), Error);
  }
}

}  // namespace
}  // namespace elastogen
