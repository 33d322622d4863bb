// SPDX-License-Identifier: Apache-2.0
// The reference meshes of bodies that a grid cuts, and fields on them.

#include "mpm_fem/fem/elastic_body.hpp"
#include "tests/curved/curved_scene.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

namespace elastogen::test {
namespace {

using fem::ElasticBody;
using fem::ElementMesh;

double volume(const ElementMesh& mesh) {
  const Array<double> parts = ElasticBody(mesh, {Material{}}).volume();
  double sum = 0;
  for (int64_t e = 0; e < parts.rows(); ++e) sum += parts(e);
  return sum;
}

/// Volume that triangles bound, by the divergence theorem.
double volume(const Surface& surface) {
  double sum = 0;
  for (int64_t t = 0; t < surface.triangles.rows(); ++t) {
    const double* a = surface.vertices.row(surface.triangles(t, 0));
    const double* b = surface.vertices.row(surface.triangles(t, 1));
    const double* c = surface.vertices.row(surface.triangles(t, 2));
    sum += a[0] * (b[1] * c[2] - b[2] * c[1]) + a[1] * (b[2] * c[0] - b[0] * c[2]) +
           a[2] * (b[0] * c[1] - b[1] * c[0]);
  }
  return sum / 6;
}

TEST(MappedBody, ABallHasItsVolumeToFourthOrder) {
  const MappedBody& ball = curved_scenes().at("pulled ball").body;
  const double truth = 4 * std::numbers::pi / 3;
  double error[2], octant[2];
  for (int k = 0; k < 2; ++k) {
    error[k] = std::abs(volume(mapped_tets(ball, 3 << k)) / truth - 1);
    octant[k] = std::abs(8 * volume(mapped_tets(ball, 3 << k, true)) / truth - 1);
    EXPECT_NEAR(error[k], octant[k], 1e-12);
  }
  std::printf("volume of a ball: off by %.1e, %.1e\n", error[0], error[1]);
  EXPECT_GT(std::log2(error[0] / error[1]), 3);
  // the surface that is voxelised has flat triangles: second order
  EXPECT_NEAR(volume(mapped_surface(ball, 32)) / truth, 1, 4e-4);
}

TEST(MappedBody, NoSceneHasTetrahedraThatAreNearlyFlat) {
  for (const auto& [name, scene] : curved_scenes())
    for (const int n : {scene.tets, 2 * scene.tets}) {
      const double shape = worst_shape(mapped_tets(scene.body, n, scene.octant));
      std::printf("%s, n = %d: worst shape %.3f\n", name.c_str(), n, shape);
      EXPECT_GT(shape, 0.045) << name;
    }
}

/// Curved elements reproduce the place itself exactly, and values at nodes.
TEST(TetField, GivesEachPointItsOwnPlace) {
  const ElementMesh mesh = mapped_tets(curved_scenes().at("hook").body, 1);
  const TetField field(mesh);
  Random random(1);
  std::uniform_real_distribution<double> unit(-1, 1);
  int inside = 0;
  for (int k = 0; k < 2000; ++k) {
    const Vec3 X = {0.5 * unit(random), 0.5 * unit(random), 0.1 * unit(random)};
    Vec3 place;
    if (!field.at(X, mesh.rest, place)) continue;
    ++inside;
    for (size_t d = 0; d < 3; ++d) EXPECT_NEAR(place[d], X[d], 1e-12);
  }
  // of the box of 1 x 1 x 0.2 m
  EXPECT_NEAR(inside / 2000.0 * 0.2, volume(mesh), 0.1 * volume(mesh));
  for (int64_t n = 0; n < mesh.rest.rows(); ++n) {
    Vec3 place;
    const double* X = mesh.rest.row(n);
    ASSERT_TRUE(field.at({X[0], X[1], X[2]}, mesh.rest, place)) << n;
  }
  Vec3 value;
  EXPECT_FALSE(field.at({0, 0, 0}, mesh.rest, value));
  EXPECT_FALSE(field.at({9, 9, 9}, mesh.rest, value));
}

}  // namespace
}  // namespace elastogen::test
