// SPDX-License-Identifier: Apache-2.0
// Tractions against resultants of the exact load, and against the nodal forces of uniform stress;
// pressures against the theorem of Gauss.

#include "mpm_fem/fem/surface_load.hpp"

#include "core/error.hpp"
#include "mpm_fem/fem/shape_functions.hpp"
#include "tests/mpm_fem/bodies.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace elastogen {
namespace {

using fem::pressure_load;
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

/// Voxels that are filled alike along x, off the middle across it.
Scene filled_column(const Material& material) {
  VoxelGrid grid = make_box(2, 2, 2, kH);
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    const int y = grid.voxel_coord(v, 1), z = grid.voxel_coord(v, 2);
    grid.fill(v) = 0.3 + 0.2 * y + 0.1 * z;
    const double place[3] = {0.5, 0.3 + 0.1 * y, 0.6 - 0.2 * z};
    for (int c = 0; c < 8; ++c) {
      grid.shape_mean(v, c) = 1;
      for (int d = 0; d < 3; ++d) grid.shape_mean(v, c) *= c >> d & 1 ? place[d] : 1 - place[d];
    }
  }
  return test::voxel_scene(grid, material, Hourglass::kFull);
}

/// Forces that hold a uniform stress in a column of partly filled voxels are the load on its end.
TEST(SurfaceLoad, IsThatOfAUniformStressInPartlyFilledVoxels) {
  const Material material = test::solid(Law::kNeoHookean, 1, 0);
  const Scene scene = filled_column(material);
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

constexpr double kPressure = 3;

TEST(PressureLoad, OnAFlatFaceIsTheForceOnIt) {
  for (const Element element : test::kAllElements) {
    const ElementMesh mesh = box_mesh(element);
    for (int axis = 0; axis < 3; ++axis)
      for (const int side : {0, 1}) {
        const double place = mesh.rest(0, axis) + side * kSize[axis] * kH;
        Array<uint8_t> end(mesh.rest.rows());
        for (int64_t n = 0; n < end.rows(); ++n)
          end(n) = std::abs(mesh.rest(n, axis) - place) < 1e-9;
        Vec3 force = {};
        force[size_t(axis)] =
            kPressure * (side ? -1 : 1) * kSize[(axis + 1) % 3] * kSize[(axis + 2) % 3] * kH * kH;
        const Array<double> wanted = surface_load(mesh, end, force);
        const Array<double> load = pressure_load(mesh, end, kPressure);
        ASSERT_EQ(load.size(), wanted.size());
        for (int64_t k = 0; k < load.size(); ++k)
          EXPECT_NEAR(load.data()[k], wanted.data()[k], 1e-15);
      }
  }
}

TEST(PressureLoad, CountsFacesOfPartlyFilledVoxelsAsTheForceDoes) {
  const Scene scene = filled_column(test::solid());
  double area = 0;
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
    if (scene.grid.voxel_coord(v, 0) == 1) area += scene.grid.fill(v) * kH * kH;
  for (const Element element : {Element::kVoxel, Element::kHex}) {
    const ElementMesh mesh = fem::voxel_mesh(scene, element);
    const Array<uint8_t> end = beyond(mesh, 0, mesh.rest(0, 0) + 2 * kH);
    const Array<double> wanted = surface_load(mesh, end, {-kPressure * area, 0, 0});
    const Array<double> load = pressure_load(mesh, end, kPressure);
    for (int64_t k = 0; k < load.size(); ++k) EXPECT_NEAR(load.data()[k], wanted.data()[k], 1e-16);
  }
}

/// [m^3]
double volume(const ElementMesh& mesh) {
  double sum = 0, X[3 * fem::kMaxNodes], dN[3 * fem::kMaxNodes], J[9];
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) {
    fem::element_nodes(mesh, e, X);
    for (const fem::QuadraturePoint& point : fem::mass_rule(mesh.element)) {
      fem::shape_gradients(mesh.element, point.xi, dN);
      fem::jacobian(mesh.element, X, dN, J);
      sum +=
          point.weight * (J[0] * (J[4] * J[8] - J[5] * J[7]) - J[1] * (J[3] * J[8] - J[5] * J[6]) +
                          J[2] * (J[3] * J[7] - J[4] * J[6]));
    }
  }
  return sum;
}

/// The divergence theorem: int n dA = 0, int X x n dA = 0, int X.n dA = 3 V. Nodes of tetrahedra
/// are all moved, so that the faces of quadratic ones are curved.
TEST(PressureLoad, OverAClosedSurfaceLeavesNothingButThreeVolumes) {
  for (const Element element : test::kAllElements) {
    ElementMesh mesh = box_mesh(element);
    test::Random random(5);
    std::uniform_real_distribution<double> moved(-0.05 * kH, 0.05 * kH);
    for (int64_t k = 0; k < mesh.rest.size() && fem::nodes_of(element) != 8; ++k)
      mesh.rest.data()[k] += moved(random);
    const Array<double> load = pressure_load(mesh, beyond(mesh, 0, -1e9), kPressure);
    double along = 0;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      EXPECT_NEAR(moment(mesh, load, d), 0, 1e-15);
      EXPECT_NEAR(moment(mesh, load, f, e) - moment(mesh, load, e, f), 0, 1e-15);
      along += moment(mesh, load, d, d);
    }
    EXPECT_NEAR(along, -3 * kPressure * volume(mesh), 1e-14);
  }
}

/// The outer face of half a tube, radii 1 and 2, length 1: `cells` around it.
struct HalfTube {
  ElementMesh mesh;
  Array<uint8_t> outside;
};

HalfTube half_tube(Element element, int cells) {
  HalfTube tube{test::block(element, 1, cells, 1, 1), {}};
  tube.outside = beyond(tube.mesh, 0, 1);
  for (int64_t n = 0; n < tube.mesh.rest.rows(); ++n) {
    const double r = 1 + tube.mesh.rest(n, 0);
    const double angle = std::numbers::pi * tube.mesh.rest(n, 1) / cells;
    tube.mesh.rest(n, 0) = r * std::cos(angle);
    tube.mesh.rest(n, 1) = r * std::sin(angle);
  }
  return tube;
}

/// int n ds along a curve is its chord turned, for any curve; int X.n dA of the arc is off
/// by the order of the faces.
TEST(PressureLoad, OnHalfACylinderIsThatOnItsDiameter) {
  for (const auto& [element, order] : {std::pair(Element::kTet4, 2), {Element::kTet10, 4}}) {
    double error[2];
    for (const int fine : {0, 1}) {
      const HalfTube tube = half_tube(element, fine ? 8 : 4);
      const Array<double> load = pressure_load(tube.mesh, tube.outside, kPressure);
      EXPECT_NEAR(moment(tube.mesh, load, 0), 0, 1e-14);
      EXPECT_NEAR(moment(tube.mesh, load, 1), -kPressure * 4, 1e-14);
      EXPECT_NEAR(moment(tube.mesh, load, 2), 0, 1e-14);
      const double along = moment(tube.mesh, load, 0, 0) + moment(tube.mesh, load, 1, 1);
      error[fine] = along / (-kPressure * 4 * std::numbers::pi) - 1;
    }
    EXPECT_NEAR(std::log2(error[0] / error[1]), order, 0.1);
  }
}

TEST(PressureLoad, IsEmptyWithoutAFace) {
  const ElementMesh mesh = box_mesh(Element::kTet10);
  Array<uint8_t> selected(mesh.rest.rows());
  EXPECT_TRUE(pressure_load(mesh, selected, kPressure).empty());
  EXPECT_FALSE(pressure_load(mesh, beyond(mesh, 0, -1e9), 0).empty());
  EXPECT_THROW(pressure_load(mesh, Array<uint8_t>(3), kPressure), Error);
  EXPECT_THROW(pressure_load(mesh, selected, std::nan("")), Error);
}

}  // namespace
}  // namespace elastogen
