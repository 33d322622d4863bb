// SPDX-License-Identifier: Apache-2.0
// Cook's membrane in linear elasticity: a tapered panel, 48 wide, 44 high at its clamped end and 16
// at the other, which carries a shear force. Values at the middle (48, 52) and the corner (48, 60)
// of the loaded edge: plane stress 23.967 and 25.19, extrapolated from independent elements; plane
// strain 30.75 and 32.30, nearly incompressible 16.44 and 17.26, as other programs print them.
#include "mpm_fem/fem/extrude.hpp"
#include "mpm_fem/integrators/fem_potential.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

/// A force along y over the edge x = 48: a uniform traction loads the middles of the edges of a
/// quadratic triangle with a third each and its corners not at all.
Array<double> shear(const ElementMesh& mesh, double force) {
  constexpr int kFaces[4][6] = {
      {0, 1, 2, 4, 5, 6}, {0, 1, 3, 4, 8, 7}, {1, 2, 3, 5, 9, 8}, {0, 2, 3, 6, 9, 7}};
  Array<double> f(mesh.rest.rows(), 3);
  double shares = 0;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    for (const auto& face : kFaces) {
      bool loaded = true;
      for (const int a : face) loaded &= std::abs(mesh.rest(mesh.elements(e, a), 0) - 48) < 1e-9;
      for (int k = 3; k < 6 && loaded; ++k) f(mesh.elements(e, face[k]), 1) += 1, shares += 1;
    }
  for (int64_t n = 0; n < f.rows(); ++n) f(n, 1) *= force / shares;
  return f;
}

struct Deflection {
  double middle, corner;
};

/// u_y of the linear problem at (48, 52) and (48, 60).
Deflection deflection(Element element, int n, double young, double poisson, double force,
                      bool plane_strain) {
  const std::array<fem::Vec2, 4> corners = {{{0, 0}, {48, 44}, {48, 60}, {0, 44}}};
  FemScene scene = scene_of(fem::extruded_quadrilateral(corners, 1, n, n, 1, element),
                            solid(Law::kNeoHookean, young, poisson));
  // clamped at x = 0, held across on one face, or on both in plane strain
  fix(scene, 0, 0, 0);
  fix(scene, 0, 0, 1);
  fix(scene, 2, 0, 2);
  if (plane_strain) fix(scene, 2, 1, 2);
  fem::FemPotential terms(scene, {.max_operations = 1e12});
  fem::Potential& potential = terms.potential;
  potential.set_force(shear(scene.mesh, force));
  // one Newton step solves the linear problem
  Array<double> u(scene.mesh.rest.rows(), 3), g = u, linear = u;
  potential.evaluate(u.data(), g.data());
  EXPECT_TRUE(
      potential.newton_step(u.data(), g.data(), TangentKind::kTrue, 0, nullptr, linear.data()));
  // mean over both faces
  Deflection sum = {0, 0};
  for (int64_t k = 0; k < u.rows(); ++k) {
    const Vec3 X = rest_of(scene.mesh, k);
    if (std::abs(X[0] - 48) > 1e-9 || std::abs(X[2] - 0.5) < 0.4) continue;  // both faces
    if (std::abs(X[1] - 52) < 1e-9) sum.middle += linear(k, 1) / 2;
    if (std::abs(X[1] - 60) < 1e-9) sum.corner += linear(k, 1) / 2;
  }
  return sum;
}

TEST(CooksMembrane, PlaneStress) {
  const Deflection plain = deflection(Element::kTet10, 16, 1, 1.0 / 3, 1, false);
  const Deflection bbar = deflection(Element::kTet10Bbar, 16, 1, 1.0 / 3, 1, false);
  printf("plane stress: tet10 %.3f, %.3f; tet10-bbar %.3f, %.3f\n", plain.middle, plain.corner,
         bbar.middle, bbar.corner);
  EXPECT_NEAR(plain.middle, 23.967, 0.003 * 23.967);
  EXPECT_NEAR(plain.corner, 25.19, 0.008 * 25.19);
  EXPECT_NEAR(bbar.middle, 23.967, 0.001 * 23.967);
  EXPECT_NEAR(bbar.corner, 25.19, 0.003 * 25.19);
}

TEST(CooksMembrane, PlaneStrain) {
  // E = 70, a traction of 6.25 over the edge of 16
  const Deflection bbar = deflection(Element::kTet10Bbar, 16, 70, 1.0 / 3, 100, true);
  printf("plane strain: tet10-bbar %.3f, %.3f\n", bbar.middle, bbar.corner);
  EXPECT_NEAR(bbar.middle, 30.75, 0.02);
  EXPECT_NEAR(bbar.corner, 32.30, 0.02);
}

TEST(CooksMembrane, NearlyIncompressiblePlaneStrain) {
  const Deflection bbar = deflection(Element::kTet10Bbar, 16, 1.12499998, 0.499999975, 1, true);
  const Deflection plain = deflection(Element::kTet10, 4, 1.12499998, 0.499999975, 1, true);
  printf("nearly incompressible: tet10-bbar %.3f, %.3f; tet10 on a quarter of the cells %.3f\n",
         bbar.middle, bbar.corner, plain.middle);
  EXPECT_NEAR(bbar.middle, 16.44, 0.02);
  EXPECT_NEAR(bbar.corner, 17.26, 0.02);
  EXPECT_LT(plain.middle, 16);  // locks
}

}  // namespace
}  // namespace elastogen::test
