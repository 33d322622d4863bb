// SPDX-License-Identifier: Apache-2.0
// Statics against closed forms: bars, homogeneous stretches, beams bent beyond the linear theory.
#include "mpm_fem/integrators/static_fem.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

using fem::solve_static;
using fem::StaticResult;

TEST(StaticFem, AHangingBarLengthensByItsWeight) {
  // rho g L^2/(2E) for nu = 0, exact at the nodes but for the strain, rho g L/E = 1e-5; the mean
  // dilatation of a quadratic tetrahedron averages a strain that is linear here
  const double length = 1, expected = 0.5e-5 * length;
  const Material material = solid(Law::kStvk, 1000 * kGravity * length / 1e-5, 0);
  for (const Element element : kAllElements) {
    FemScene scene = box_of(element, 2, 2, 8, length / 8, material);
    scene.gravity = {0, 0, -kGravity};
    scene.mass_kind = fem::Mass::kConsistent;
    clamp(scene, 2, length);
    const StaticResult result = solve_static(scene);
    ASSERT_TRUE(result.converged) << element_name(element);
    const double tip = -plane_mean(scene, result.u, 2, 0, 2);
    EXPECT_NEAR(tip, expected, (element == Element::kTet10Bbar ? 2e-3 : 2e-5) * expected)
        << element_name(element);
    const double weight = 1000 * kGravity * length / 16;
    EXPECT_NEAR(total(result.reaction, 2), weight, 1e-9 * weight);
    // the elastic energy is half the work of gravity
    const double stored = result.energy.elastic + result.energy.hourglass;
    EXPECT_NEAR(stored, -result.energy.gravity / 2, 2e-5 * stored);
  }
}

/// A cube with symmetry planes x = 0, y = 0, z = 0, its face x = 1, and where asked for y = 1, at a
/// stretch.
FemScene stretched_cube(Element element, Law law, double stretch, bool biaxial) {
  FemScene scene = element == Element::kVoxel ? box_of(element, 2, 2, 2, 0.5, solid(law))
                                              : scene_of(block(element, 2, 2, 2, 0.5, 0.15),
                                                         solid(law));  // an inner node is moved
  for (int axis = 0; axis < 3; ++axis) fix(scene, axis, 0, axis);
  fix(scene, 0, 1, 0);
  if (biaxial) fix(scene, 1, 1, 1);
  scene.motion = [rest = scene.mesh.rest, stretch](double share, Out<double> u) {
    for (int64_t n = 0; n < u.rows; ++n)
      for (int i = 0; i < 3; ++i) u(n, i) = share * (stretch - 1) * rest(n, i);
  };
  return scene;
}

struct Row {
  Law law;
  double stretch, P, lateral;
};

/// Nominal stress and lateral stretch of every element against a row of a table.
void expect_response(const Row& row, bool biaxial) {
  for (const Element element : kAllElements) {
    // with one pressure in a quadratic tetrahedron the cube buckles at 0.52
    if (element == Element::kTet10Bbar && row.stretch < 0.6) continue;
    FemScene scene = stretched_cube(element, row.law, row.stretch, biaxial);
    const StaticResult result = solve_static(scene);
    ASSERT_TRUE(result.converged) << law_name(row.law) << ' ' << row.stretch;
    double force = 0;
    for (const int64_t n : plane(scene.mesh, 0, 1)) force += result.reaction(n, 0);
    const double lateral = 1 + plane_mean(scene, result.u, 2, 1, 2);
    EXPECT_NEAR(force, row.P, 1e-6) << law_name(row.law) << ' ' << element_name(element);
    EXPECT_NEAR(lateral, row.lateral, 1e-6) << law_name(row.law) << ' ' << row.stretch;
  }
}

TEST(StaticFem, AxialStretchGivesTheForceOfTheLaw) {
  // E = 1, nu = 0.3; P and the lateral stretch: roots of t_2 = 0 of the textbook energies
  std::vector<Row> rows = {{Law::kNeoHookean, 0.5, -0.935352, 1.210767},
                           {Law::kNeoHookean, 1.5, 0.378280, 0.880175},
                           {Law::kNeoHookean, 2.0, 0.646745, 0.798078},
                           {Law::kStableNeoHookean, 0.5, -0.705854, 1.094647},
                           {Law::kStableNeoHookean, 2.0, 0.732113, 0.771045},
                           {Law::kFixedCorotated, 0.5, -0.644286, 1.147137},
                           {Law::kFixedCorotated, 2.0, 0.836684, 0.773170}};
  for (const double a : {0.9, 2.0})
    rows.push_back({Law::kStvk, a, a * (a * a - 1) / 2, std::sqrt(1 - 0.3 * (a * a - 1))});
  for (const double a : {0.7, 1.5})
    rows.push_back({Law::kHencky, a, std::log(a) / a, std::pow(a, -0.3)});
  for (const Row& row : rows) expect_response(row, false);
}

TEST(StaticFem, EquibiaxialStretchGivesTheForceOfTheLaw) {
  const Row rows[] = {{Law::kNeoHookean, 1.5, 0.467916, 0.652019},
                      {Law::kStableNeoHookean, 1.5, 0.541941, 0.580612},
                      {Law::kFixedCorotated, 1.5, 0.510958, 0.560261},
                      {Law::kStvk, 1.2, 0.377143, 0.789213}};
  for (const Row& row : rows) expect_response(row, true);
}

/// A cantilever of length 1 and thickness t with K = w L^3/(E I) = 11.772 by its own weight.
FemScene heavy_beam(int slender, int across) {
  const double t = 1.0 / slender;
  FemScene scene =
      scene_of(block(Element::kTet10, slender * across, across, across, t / across),
               solid(Law::kFixedCorotated, 1000 * kGravity * 12 / (11.772 * t * t), 0));
  scene.gravity = {0, 0, -kGravity};
  clamp(scene, 0, 0);
  return scene;
}

TEST(StaticFem, ATipLoadBendsABeamAsTheElastica) {
  // P L^2/(E I): deflection and x of the tip, both over L
  const double rows[4][3] = {{0.5, 0.16214, 0.98408},
                             {1, 0.30172, 0.94357},
                             {3, 0.60325, 0.74558},
                             {10, 0.81061, 0.44500}};
  const double t = 1.0 / 40, young = 1e6;
  FemScene scene =
      scene_of(block(Element::kTet10, 40, 1, 1, t), solid(Law::kFixedCorotated, young, 0));
  clamp(scene, 0, 0);
  const std::vector<int64_t> tip = plane(scene.mesh, 0, 1);
  for (const auto& [load, deflection, x] : rows) {
    scene.traction = Array<double>(scene.mesh.rest.rows(), 3);
    for (const int64_t n : tip)
      scene.traction(n, 2) = -load * young * t * t * t * t / 12 / double(tip.size());
    const StaticResult result = solve_static(scene);
    ASSERT_TRUE(result.converged);
    const double down = -plane_mean(scene, result.u, 0, 1, 2);
    const double along = 1 + plane_mean(scene, result.u, 0, 1, 0);
    printf("P L^2/EI = %4.1f: %.5f, %.5f; %d steps\n", load, down, along, result.newton_steps);
    EXPECT_NEAR(down, deflection, 0.002 * deflection);  // a solid shears besides, (t/L)^2
    EXPECT_NEAR(along, x, 0.002 * x);
  }
}

TEST(StaticFem, ReportsTheRoundingErrorThatItEndsAt) {
  // E/(rho g h) = 1e9: the rounding of strains is worth 5e-7 of the weight
  FemScene scene = box_of(Element::kHex, 8, 2, 2, 0.1, solid(Law::kStvk, 1e12, 0.3));
  scene.gravity = {0, 0, -kGravity};
  clamp(scene, 0, 0);
  const StaticResult result = solve_static(scene);
  EXPECT_TRUE(result.converged);
  EXPECT_EQ(result.stop, fem::NewtonStop::kRoundOff);
  EXPECT_GT(result.residual, 1e-10);
  EXPECT_GE(result.floor, result.residual);
  printf("rounding: residual %.1e, bound %.1e, stop %s\n", result.residual, result.floor,
         std::string(stop_name(result.stop)).c_str());
}

TEST(StaticFem, ABodyThatNothingHoldsHasNoEquilibrium) {
  FemScene scene = box_of(Element::kTet4, 2, 1, 1, 0.1, solid(Law::kNeoHookean, 1e5));
  scene.gravity = {0, 0, -kGravity};
  const StaticResult result = solve_static(scene, {.smallest_increment = 0.2});
  EXPECT_FALSE(result.converged);
  EXPECT_LT(result.load_factor, 1);
}

TEST(StaticFem, SmallerIncrementsLeadToTheSameEquilibrium) {
  // with six Newton steps each the load has to be divided
  const FemScene scene = heavy_beam(10, 1);
  const StaticResult whole = solve_static(scene), divided = solve_static(scene, {.max_newton = 6});
  ASSERT_TRUE(whole.converged && divided.converged);
  EXPECT_EQ(whole.increments, 1);
  EXPECT_GT(divided.increments, 2);
  EXPECT_EQ(divided.load_factor, 1);
  for (int64_t k = 0; k < whole.u.size(); ++k)
    ASSERT_NEAR(divided.u.data()[k], whole.u.data()[k], 1e-8);
}

TEST(StaticFem, HasTheSameBitsOnAnyNumberOfThreads) {
  FemScene scene = heavy_beam(10, 2);
  const StaticResult many = solve_static(scene, {.first_increment = 0.5});
  const ThreadLimit limit(1);
  const StaticResult one = solve_static(scene, {.first_increment = 0.5});
  EXPECT_EQ(many.u, one.u);
  EXPECT_EQ(many.residual, one.residual);
}

TEST(StaticFem, ConjugateGradientsComeToTheSameEquilibrium) {
  const FemScene scene = heavy_beam(10, 1);
  const StaticResult direct = solve_static(scene);
  const StaticResult iterative = solve_static(scene, {.linear = {.max_operations = 0}});
  ASSERT_TRUE(direct.converged && iterative.converged);
  for (int64_t k = 0; k < direct.u.size(); ++k)
    ASSERT_NEAR(iterative.u.data()[k], direct.u.data()[k], 1e-7);
}

TEST(StaticFem, RejectsWhatItsDocumentationForbids) {
  FemScene scene = box_of(Element::kHex, 1, 1, 1, 1, solid());
  EXPECT_THROW(solve_static(scene, {.tolerance = 0}), Error);
  EXPECT_THROW(solve_static(scene, {.first_increment = 0}), Error);
  scene.traction = Array<double>(3, 3);
  EXPECT_THROW(solve_static(scene), Error);
  scene.traction = {};
  scene.fixed = Array<uint8_t>(8, 1);
  EXPECT_THROW(solve_static(scene), Error);
  scene.fixed = {};
  scene.mass = Array<double>(8);
  EXPECT_THROW(solve_static(scene), Error);  // a mass of 0
  scene.mass.fill(1);
  scene.mass_kind = fem::Mass::kConsistent;
  EXPECT_THROW(solve_static(scene), Error);
}

}  // namespace
}  // namespace elastogen::test
