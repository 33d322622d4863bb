// SPDX-License-Identifier: Apache-2.0
// Linear statics of beams, strips and sheets, assembled from the element: bending against
// Timoshenko, plates and converged solids, twist against Saint-Venant. Tables are errors in per
// cent; n is the number of voxels through the thickness.

#include "tests/support/element_assembly.hpp"
#include "voxelize/bricks.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::box_scene;

constexpr double kPoisson[5] = {0, 0.3, 0.45, 0.49, 0.499};
constexpr double kGravity = 9.81;

Material beam_solid(double young, double poisson, double density = 1000) {
  return {"test", Law::kNeoHookean, young, poisson, density};
}

/// Mean displacement component over the nodes of the plane x = place, weighted by their area.
double plane_mean(const VoxelGrid& grid, const Eigen::VectorXd& u, int place, int component) {
  double sum = 0, weight = 0;
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    if (grid.node_coord(n, 0) != place) continue;
    int share = 0;
    for (int c = 0; c < 8; ++c) share += grid.voxels(n, c) >= 0;
    sum += share * u(3 * n + component), weight += share;
  }
  return sum / weight;
}

int64_t node_at(const VoxelGrid& grid, int x, int y, int z) {
  for (int64_t n = 0; n < grid.node_count(); ++n)
    if (grid.node_coord(n, 0) == x && grid.node_coord(n, 1) == y && grid.node_coord(n, 2) == z)
      return n;
  return -1;
}

/// Holds the nodes of the plane x = 0.
std::map<int, double> clamp_root(const VoxelGrid& grid) {
  std::map<int, double> held;
  for (int64_t n = 0; n < grid.node_count(); ++n)
    for (int i = 0; i < 3; ++i)
      if (grid.node_coord(n, 0) == 0) held[int(3 * n + i)] = 0;
  return held;
}

/// A total force on the end face x = place, shared by area.
Eigen::VectorXd end_load(const VoxelGrid& grid, int place, int component, double force) {
  Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * grid.node_count());
  double faces = 0;
  for (const bool fill : {false, true})
    for (int64_t n = 0; n < grid.node_count(); ++n) {
      if (grid.node_coord(n, 0) != place) continue;
      int share = 0;
      for (int c = 0; c < 8; ++c) share += grid.voxels(n, c) >= 0;
      if (fill)
        f(3 * n + component) = force * share / faces;
      else
        faces += share;
    }
  return f;
}

/// Share of node k of n + 1 over the thickness in the traction 3/2 (1 - (2 z/t)^2) of mean 1.
double parabola_share(int k, int n) {
  constexpr double kPoint[3] = {0.112701665379258, 0.5, 0.887298334620742};
  constexpr double kWeight[3] = {5.0 / 18, 8.0 / 18, 5.0 / 18};
  double share = 0;
  for (const int layer : {k - 1, k}) {
    if (layer < 0 || layer >= n) continue;
    for (int q = 0; q < 3; ++q) {
      const double z = 2 * (layer + kPoint[q]) / n - 1;
      const double hat = layer == k ? 1 - kPoint[q] : kPoint[q];
      share += kWeight[q] * hat * 1.5 * (1 - z * z) / n;
    }
  }
  return share;
}

/// Keeps the plane x = 0 of a beam n voxels thick and lets it contract: the plane carries the
/// weight as a parabolic shear traction and is held against rigid motion without a reaction.
std::map<int, double> hold_contracting_root(const VoxelGrid& grid, int n, double weight,
                                            Eigen::VectorXd& f) {
  std::map<int, double> held;
  for (int64_t k = 0; k < grid.node_count(); ++k) {
    if (grid.node_coord(k, 0) > 0) continue;
    held[int(3 * k)] = 0;
    const int y = grid.node_coord(k, 1);
    const double across = (y == 0 || y == n ? 0.5 : 1.0) / n;
    f(3 * k + 2) += weight * across * parabola_share(grid.node_coord(k, 2), n);
  }
  const int corner = int(3 * node_at(grid, 0, 0, 0)), side = int(3 * node_at(grid, 0, n, 0));
  held[corner + 1] = held[corner + 2] = held[side + 2] = 0;
  return held;
}

enum class Root { kClamped, kContracting };

/// The variance weight c_h: by the rule of finish_scene, or one for all.
enum class Weight { kRule, kMean, kMu, kHalfYoung, kSheet };

void set_weight(Scene& scene, Weight weight) {
  const Material& m = scene.materials[0];
  const double half = m.young / 2;
  if (weight == Weight::kMean) scene.variance.fill((m.mu() + half) / 2);
  if (weight == Weight::kMu) scene.variance.fill(m.mu());
  if (weight == Weight::kHalfYoung) scene.variance.fill(half);
  if (weight == Weight::kSheet) scene.variance.fill(half / (1 - m.poisson * m.poisson));
}

/// The beam 10n x n x n with L = 1, thickness 0.1, E = 1e8, rho = 1000, bent by its own weight.
struct Cantilever {
  Scene scene;
  Eigen::SparseMatrix<double> K;
  Eigen::VectorXd u;
  double error = 0;  ///< deflection against Timoshenko's [per cent]
};

Cantilever cantilever(int n, double poisson, Root root, Hourglass hourglass,
                      Weight weight = Weight::kRule) {
  constexpr double kYoung = 1e8, kDensity = 1000, kThick = 0.1, kArea = kThick * kThick;
  constexpr double kInertia = kArea * kArea / 12, kLoad = kDensity * kGravity * kArea;
  Cantilever beam;
  beam.scene =
      box_scene(10 * n, n, n, kThick / n, beam_solid(kYoung, poisson, kDensity), hourglass);
  set_weight(beam.scene, weight);
  const VoxelGrid& grid = beam.scene.grid;
  Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * grid.node_count());
  for (int64_t k = 0; k < grid.node_count(); ++k) f(3 * k + 2) = -beam.scene.mass(k) * kGravity;
  const std::map<int, double> held =
      root == Root::kClamped ? clamp_root(grid) : hold_contracting_root(grid, n, kLoad, f);
  beam.K = test::rest_stiffness(beam.scene);
  beam.u = test::solve(beam.K, f, held);

  const double kappa = 10 * (1 + poisson) / (12 + 11 * poisson);
  const double shear_modulus = kYoung / (2 * (1 + poisson));
  const double timoshenko =
      kLoad / (8 * kYoung * kInertia) + kLoad / (2 * kappa * shear_modulus * kArea);
  const double deflection = plane_mean(grid, beam.u, 0, 2) - plane_mean(grid, beam.u, 10 * n, 2);
  beam.error = 100 * (deflection / timoshenko - 1);
  return beam;
}

struct BendingRow {
  int n;
  Weight weight;
  Hourglass hourglass;
  double error[5];  // at kPoisson, against Timoshenko [per cent]
};

void expect_bending(Root root, const std::vector<BendingRow>& rows) {
  constexpr const char* kWeights[5] = {"rule", "mean", "mu", "E/2", "sheet"};
  for (const BendingRow& row : rows) {
    printf("n = %d, c_h %-4s%s:", row.n, kWeights[int(row.weight)],
           row.hourglass == Hourglass::kFull ? ", torsion correction" : "");
    for (int k = 0; k < 5; ++k) {
      const double error = cantilever(row.n, kPoisson[k], root, row.hourglass, row.weight).error;
      printf(" %+.2f", error);
      EXPECT_NEAR(error, row.error[k], 0.2) << "n " << row.n << " nu " << kPoisson[k];
    }
    printf(" %%\n");
  }
}

TEST(BeamStatics, ClampedBeamBendsAsTheTableSays) {
  // linear elasticity, computed once by another program; the converged 3-D solution has
  // 0.0, -0.94, -2.25, -2.74, -2.85
  constexpr Hourglass kVariance = Hourglass::kVariance, kFull = Hourglass::kFull;
  expect_bending(Root::kClamped,
                 {{1, Weight::kRule, kVariance, {-0.13, -0.15, -0.16, -0.16, -0.16}},
                  {1, Weight::kMean, kVariance, {-0.13, 12.76, 18.00, 19.29, 19.57}},
                  {2, Weight::kRule, kVariance, {-0.13, 0.02, -2.94, -4.21, -4.53}},
                  {2, Weight::kRule, kFull, {-0.13, 0.08, -2.77, -4.00, -4.32}},
                  {2, Weight::kMu, kVariance, {-0.13, 3.20, 1.67, 0.81, 0.58}},
                  {2, Weight::kHalfYoung, kVariance, {-0.13, -2.96, -7.09, -8.69, -9.09}},
                  {4, Weight::kRule, kVariance, {-0.04, -0.85, -2.74, -3.47, -3.65}},
                  {4, Weight::kRule, kFull, {-0.04, -0.82, -2.66, -3.38, -3.56}},
                  {4, Weight::kMu, kVariance, {-0.04, -0.06, -1.54, -2.15, -2.30}},
                  {4, Weight::kHalfYoung, kVariance, {-0.04, -1.63, -3.89, -4.74, -4.95}}});
}

TEST(BeamStatics, ResolvedClampedBeamBendsAsTheTableSays) {
  expect_bending(Root::kClamped,
                 {{8, Weight::kRule, Hourglass::kVariance, {-0.01, -0.91, -2.37, -2.92, -3.05}}});
}

TEST(BeamStatics, BeamWhoseRootMayContractBendsAsTimoshenkoSays) {
  constexpr Hourglass kVariance = Hourglass::kVariance, kFull = Hourglass::kFull;
  expect_bending(Root::kContracting,
                 {{1, Weight::kRule, kVariance, {-0.13, -0.15, -0.16, -0.16, -0.16}},
                  {2, Weight::kRule, kVariance, {-0.13, 1.19, 0.24, -0.17, -0.27}},
                  {2, Weight::kRule, kFull, {-0.13, 1.19, 0.24, -0.17, -0.27}},
                  {2, Weight::kMu, kVariance, {-0.13, 4.39, 4.86, 4.82, 4.81}},
                  {2, Weight::kHalfYoung, kVariance, {-0.13, -1.81, -3.95, -4.67, -4.84}},
                  {4, Weight::kRule, kVariance, {-0.04, 0.23, -0.06, -0.18, -0.21}},
                  {4, Weight::kRule, kFull, {-0.04, 0.23, -0.06, -0.18, -0.21}}});
  for (const double poisson : kPoisson)
    EXPECT_LE(std::abs(cantilever(2, poisson, Root::kContracting, Hourglass::kFull).error), 2)
        << poisson;
}

TEST(BeamStatics, ShareOfTheVarianceTermInBendingFallsWithTheSquareOfTheResolution) {
  const auto share = [](int n, double poisson) {
    Cantilever beam = cantilever(n, poisson, Root::kClamped, Hourglass::kVariance);
    const double energy = beam.u.dot(beam.K * beam.u);
    beam.scene.hourglass = Hourglass::kOff;
    return 100 * (1 - beam.u.dot(test::rest_stiffness(beam.scene) * beam.u) / energy);
  };
  EXPECT_NEAR(share(1, 0), 98.9, 0.5);
  EXPECT_NEAR(share(2, 0), 24.7, 0.5);
  EXPECT_NEAR(share(4, 0), 6.2, 0.5);
  EXPECT_NEAR(share(2, 0.499), 25.4, 0.5);
  EXPECT_NEAR(share(4, 0.499), 7.0, 0.5);
}

/// Tip deflection of the beam nx x n x n, as long as 15 half thicknesses, per unit of end shear.
double tip_compliance(int nx, int n, double poisson) {
  const Scene scene = box_scene(nx, n, n, 2.0 / n, beam_solid(1, poisson), Hourglass::kVariance);
  const Eigen::VectorXd f = end_load(scene.grid, nx, 2, 1);
  const Eigen::VectorXd u = test::solve(test::rest_stiffness(scene), f, clamp_root(scene.grid));
  return plane_mean(scene.grid, u, nx, 2);
}

TEST(BeamStatics, BeamTwoVoxelsThickUnderEndShearComesNearTheResolvedOne) {
  // compliance of 15x2x2 voxels over that of 60x8x8
  const double ratio[5] = {0.997, 1.008, 0.993, 0.985, 0.983};
  printf("compliance of 15x2x2 over 60x8x8:");
  for (int k = 0; k < 5; ++k) {
    const double measured = tip_compliance(15, 2, kPoisson[k]) / tip_compliance(60, 8, kPoisson[k]);
    printf(" %.4f", measured);
    EXPECT_NEAR(measured, ratio[k], 0.001) << kPoisson[k];
  }
  printf("\n");
}

/// Tip deflection of a sheet of length 20 thicknesses in cylindrical bending (u_y = 0) under its
/// own weight, over that of a plate, rho g t L^4/(8 D) + rho g L^2/(2 (5/6) G).
double sheet_ratio(int n, double poisson, Weight weight, Hourglass hourglass) {
  constexpr double kYoung = 1e8, kThick = 0.05;
  Scene scene =
      box_scene(20 * n, n == 1 ? 2 : 1, n, kThick / n, beam_solid(kYoung, poisson), hourglass);
  set_weight(scene, weight);
  const VoxelGrid& grid = scene.grid;
  Eigen::VectorXd f = Eigen::VectorXd::Zero(3 * grid.node_count());
  std::map<int, double> held = clamp_root(grid);
  for (int64_t k = 0; k < grid.node_count(); ++k) {
    f(3 * k + 2) = -scene.mass(k) * kGravity;
    held[int(3 * k + 1)] = 0;
  }
  const Eigen::VectorXd u = test::solve(test::rest_stiffness(scene), f, held);
  const double rigidity = kYoung * std::pow(kThick, 3) / (12 * (1 - poisson * poisson));
  const double shear_modulus = kYoung / (2 * (1 + poisson));
  const double reference = 1000 * kGravity * (kThick / (8 * rigidity) + 0.6 / shear_modulus);
  return -plane_mean(grid, u, 20 * n, 2) / reference;
}

TEST(BeamStatics, SheetBendsAsAPlateByTheFactorsOfTheTable) {
  // the first row by the rule of finish_scene, the others with c_h for all voxels
  const struct {
    int n;
    Weight weight;
    double ratio[5];
  } rows[] = {{1, Weight::kRule, {1.000, 1.000, 0.999, 0.999, 0.999}},
              {1, Weight::kSheet, {1.000, 1.000, 0.999, 0.999, 0.999}},
              {1, Weight::kHalfYoung, {1.000, 1.098, 1.252, 1.314, 1.330}},
              {1, Weight::kMean, {1.000, 1.241, 1.482, 1.572, 1.594}},
              {2, Weight::kMean, {1.000, 1.047, 1.073, 1.079, 1.080}},
              {2, Weight::kHalfYoung, {1.000, 1.018, 1.037, 1.041, 1.042}},
              {4, Weight::kMean, {1.000, 1.009, 1.010, 1.009, 1.008}},
              {4, Weight::kHalfYoung, {1.000, 1.002, 1.002, 1.000, 1.000}}};
  for (const auto& row : rows)
    for (const Hourglass hourglass : {Hourglass::kVariance, Hourglass::kFull})
      for (int k = 0; k < 5; ++k)
        EXPECT_NEAR(sheet_ratio(row.n, kPoisson[k], row.weight, hourglass), row.ratio[k], 0.001)
            << "n " << row.n << " nu " << kPoisson[k];
}

TEST(BeamStatics, PartlyFilledStripHasTheStiffnessOfItsThickness) {
  constexpr double kYoung = 1e6, kH = 0.1;
  for (const double fill : {0.5, 0.25}) {
    VoxelGrid grid = make_box(20, 1, 1, kH);
    grid.fill.fill(fill);
    const Scene scene = test::scene_of(grid, beam_solid(kYoung, 0));
    const Eigen::SparseMatrix<double> K = test::rest_stiffness(scene);
    const std::map<int, double> held = clamp_root(grid);
    const Eigen::VectorXd bent = test::solve(K, end_load(grid, 20, 2, 1), held);
    const double inertia = std::pow(kH, 4) * std::pow(fill, 3) / 12;
    const double bending = plane_mean(grid, bent, 20, 2) * 3 * kYoung * inertia / 8;
    const Eigen::VectorXd drawn = test::solve(K, end_load(grid, 20, 0, 1), held);
    const double axial = plane_mean(grid, drawn, 20, 0) * kYoung * fill * kH * kH / 2;
    printf("strip of fill %.2f: bending compliance over the beam's %.4f\n", fill, bending);
    EXPECT_NEAR(bending, 1, 0.005) << fill;
    EXPECT_NEAR(axial, 1, 1e-9) << fill;
  }
}

/// Torsional stiffness of the bar 4n x n x n, warping free, over Saint-Venant's.
double twist_ratio(int n, double poisson, Hourglass hourglass, Weight weight = Weight::kRule) {
  Scene scene = box_scene(4 * n, n, n, 1.0 / n, beam_solid(1, poisson), hourglass);
  set_weight(scene, weight);
  const VoxelGrid& grid = scene.grid;
  std::map<int, double> held;
  for (int64_t k = 0; k < grid.node_count(); ++k) {
    const int x = grid.node_coord(k, 0);
    if (x != 0 && x != 4 * n) continue;
    const double angle = x == 0 ? -0.5 : 0.5;
    held[int(3 * k + 1)] = -angle * (grid.rest(k, 2) - 0.5);
    held[int(3 * k + 2)] = angle * (grid.rest(k, 1) - 0.5);
  }
  held[int(3 * node_at(grid, 0, 0, 0))] = 0;
  const Eigen::SparseMatrix<double> K = test::rest_stiffness(scene);
  const Eigen::VectorXd u = test::solve(K, Eigen::VectorXd::Zero(K.rows()), held);
  // twice the energy is torque times angle; the angle is 1, the length 4, the side 1
  const double shear_modulus = 1 / (2 * (1 + poisson));
  return u.dot(K * u) * 4 / (0.140577 * shear_modulus);
}

TEST(BeamStatics, TwistWithTheTorsionCorrectionIsThatOfTheTableAtEveryPoissonRatio) {
  const std::pair<int, double> table[] = {{1, 1.186}, {2, 1.186}, {3, 1.090},
                                          {4, 1.052}, {6, 1.024}, {8, 1.014}};
  for (const auto& [n, ratio] : table)
    for (const double poisson : {0.0, 0.3, 0.499}) {
      if (n == 8 && poisson > 0) continue;  // the ratio does not depend on it
      EXPECT_NEAR(twist_ratio(n, poisson, Hourglass::kFull), ratio, 1e-3) << n << ' ' << poisson;
    }
}

TEST(BeamStatics, TwistWithoutTheCorrectionIsTooStiffByWhatTheTableSays) {
  const struct {
    int n;
    double ratio[3], tolerance;  // at nu 0, 0.3, 0.499
  } rows[] = {{1, {2.37, 2.73, 2.96}, 0.01},
              {2, {1.48, 1.57, 1.63}, 0.01},
              {3, {1.22, 1.26, 1.29}, 0.01},
              {4, {1.126, 1.151, 1.167}, 2e-3},
              {6, {1.057, 1.068, 1.075}, 2e-3}};
  constexpr double kRatios[3] = {0, 0.3, 0.499};
  for (const auto& row : rows)
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(twist_ratio(row.n, kRatios[k], Hourglass::kVariance, Weight::kMean), row.ratio[k],
                  row.tolerance)
          << row.n << ' ' << kRatios[k];
}

}  // namespace
}  // namespace elastogen
