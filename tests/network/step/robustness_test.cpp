// SPDX-License-Identifier: Apache-2.0
// Inverted and collapsed states, precision, and the independence of units and place.
#include "network/solver.hpp"
#include "tests/network/scenes.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

Scene free_cube(int n, Law law) {
  Scene scene = scene_on(make_box(n, n, n, 0.1), solid(1e5, 0.3, law));
  finish_scene(scene);
  return scene;
}

/// Runs until the body is back in shape; the last report.
StepReport recover(const Scene& scene, State state) {
  Solver solver(scene, {});
  StepReport report;
  for (int k = 0; k < 120; ++k) {
    report = solver.step(state);
    EXPECT_TRUE(report.finite);
  }
  return report;
}

void expect_in_shape(const StepReport& report, Law law) {
  EXPECT_TRUE(report.converged) << law_name(law);
  EXPECT_GT(report.min_j, 0.9) << law_name(law);
  EXPECT_LT(report.energy.elastic, 1e-3 * 1e5 * 1e-3) << law_name(law);
}

TEST(Robustness, AMirroredVoxelRecovers) {
  for (const Law law :
       {Law::kFixedCorotated, Law::kNeoHookean, Law::kStableNeoHookean, Law::kHencky}) {
    const Scene scene = free_cube(1, law);
    State state = initial_state(scene);
    for (int64_t n = 0; n < 8; ++n) state.x(n, 0) = 0.1 - state.x(n, 0);
    expect_in_shape(recover(scene, state), law);
  }
}

TEST(Robustness, AFlattenedCubeRecovers) {
  for (const Law law :
       {Law::kFixedCorotated, Law::kNeoHookean, Law::kStableNeoHookean, Law::kHencky}) {
    const Scene scene = free_cube(3, law);
    State state = initial_state(scene);
    for (int64_t n = 0; n < scene.grid.node_count(); ++n) state.x(n, 1) = 0;
    expect_in_shape(recover(scene, state), law);
  }
}

TEST(Robustness, TheHourglassEnergyOfAMirroredBodyDoesNotDependOnItsAttitude) {
  const Scene scene = free_cube(2, Law::kNeoHookean);
  const std::vector<double> noise = random_field(scene, 0.02, 5);
  // hourglass energy of a mirrored, shaken body turned by R
  const auto energy = [&](const Mat3<double>& R) {
    State state = initial_state(scene);
    Array<double> bent = state.x;
    for (int64_t n = 0; n < state.x.rows(); ++n)
      for (int i = 0; i < 3; ++i) {
        state.x(n, i) = bent(n, i) = 0;
        for (int j = 0; j < 3; ++j) {
          const double mirrored = (j == 0 ? -1 : 1) * scene.grid.rest(n, j);
          state.x(n, i) += R(i, j) * mirrored;
          bent(n, i) += R(i, j) * (mirrored + noise[size_t(3 * n + j)]);
        }
      }
    IncrementalPotential potential(scene);
    potential.begin_step(state, {TimeScheme::kEuler, scene.dt, 1});
    state.x = bent;
    const std::vector<double> u = displacement(scene, state);
    std::vector<double> g(u.size());
    return potential.evaluate<double>(u.data(), g.data()).hourglass;
  };
  Random random(2);
  // it does not depend on R
  const double upright = energy(identity<double>());
  EXPECT_GT(upright, 0);
  for (int k = 0; k < 5; ++k) EXPECT_NEAR(energy(rotation(random)), upright, 1e-12 * upright);
}

TEST(Robustness, ACollapsedVoxelHasAFiniteForce) {
  for (const Law law :
       {Law::kFixedCorotated, Law::kNeoHookean, Law::kStableNeoHookean, Law::kStvk, Law::kHencky}) {
    const Scene scene = free_cube(1, law);
    // all nodes at one point
    State state = initial_state(scene);
    state.x.fill(0.05);
    IncrementalPotential potential(scene);
    potential.begin_step(state, {TimeScheme::kEuler, scene.dt, 1});
    const std::vector<double> u = displacement(scene, state);
    std::vector<double> g(u.size());
    std::vector<float> single(u.size());
    // energy and forces in both precisions
    const PotentialValue value = potential.evaluate<double>(u.data(), g.data());
    potential.evaluate<float>(u.data(), single.data());
    EXPECT_TRUE(std::isfinite(value.total())) << law_name(law);
    EXPECT_GT(value.elastic, 0);
    for (size_t k = 0; k < g.size(); ++k) {
      ASSERT_TRUE(std::isfinite(g[k])) << law_name(law);
      ASSERT_TRUE(std::isfinite(single[k])) << law_name(law);
    }
    // and the product with the Hessian
    potential.linearise(u.data());
    const std::vector<float> p(u.size(), 1.f);
    potential.hessian_product(p.data(), single.data());
    for (const float value : single) ASSERT_TRUE(std::isfinite(value)) << law_name(law);
  }
}

/// |gradient in float64 - gradient in float| of a step from `before` at `after`, over the reference
/// force.
double float_noise(const Scene& scene, const State& before, const State& after) {
  IncrementalPotential potential(scene);
  potential.begin_step(before, {TimeScheme::kEuler, scene.dt, 1});
  const std::vector<double> u = displacement(scene, after);
  std::vector<double> g(u.size());
  std::vector<float> single(u.size());
  potential.evaluate<double>(u.data(), g.data());
  potential.evaluate<float>(u.data(), single.data());
  for (size_t i = 0; i < g.size(); ++i) g[i] -= double(single[i]);
  return norm(g) / reference_force(scene);
}

/// The state turned as a whole.
State turned(const Mat3<double>& R, State state) {
  for (Array<double>* array : {&state.x, &state.v})
    for (int64_t n = 0; n < array->rows(); ++n) {
      const double v[3] = {(*array)(n, 0), (*array)(n, 1), (*array)(n, 2)};
      for (int i = 0; i < 3; ++i) (*array)(n, i) = R(i, 0) * v[0] + R(i, 1) * v[1] + R(i, 2) * v[2];
    }
  return state;
}

/// Laws by stretches have it in every state, those of strain where the body has turned: before that
/// their gradient is closer.
TEST(Robustness, FloatFloorIsTheNoiseOfTheFloatGradient) {
  Random random(11);
  const Mat3<double> R = rotation_by(1, random);
  for (const Law law : {Law::kNeoHookean, Law::kHencky})
    for (const double poisson : {0.0, 0.3, 0.45, 0.49}) {
      const Scene scene = clamped_beam(24, 6, 6, 0.025, solid(2e5, poisson, law));
      Solver solver(scene, {.tolerance = 1e-6});
      State state = initial_state(scene);
      double noise = 0, noise_turned = 0;
      constexpr int kSteps = 6;
      for (int k = 0; k < kSteps; ++k) {
        const State before = state;
        ASSERT_TRUE(solver.step(state).converged);
        noise += float_noise(scene, before, state) / kSteps;
        noise_turned += float_noise(scene, turned(R, before), turned(R, state)) / kSteps;
      }
      printf("%s, nu %.2f: float floor measured %.2e, turned %.2e, estimate %.2e\n",
             std::string(law_name(law)).c_str(), poisson, noise, noise_turned, float_floor(scene));
      EXPECT_LT(noise, 2 * float_floor(scene));
      // the displacements of a turned body are rounded too, which is the most of it at nu 0
      EXPECT_LT(noise_turned, 3 * float_floor(scene));
      EXPECT_GT(noise_turned, float_floor(scene) / 3);
      if (law == Law::kHencky) {
        EXPECT_GT(noise, float_floor(scene) / 2);
      }
    }
}

/// Displacement over h of a beam after eight steps; every length scaled by s, gravity kept.
std::vector<double> dimensionless_result(double s, double tolerance, double offset = 0) {
  const double h = 0.025 * s;
  Scene scene = scene_on(make_box(10, 3, 3, h, {offset, offset, -offset}), solid(1e5 * s, 0.4));
  pin_below(scene, 0, offset + h / 2);
  scene.gravity = {0, -9.81, 0};
  scene.dt = std::sqrt(s) / 60;
  finish_scene(scene);
  Solver solver(scene, {.tolerance = tolerance});
  State state = initial_state(scene);
  for (int k = 0; k < 8; ++k) {
    const StepReport report = solver.step(state);
    EXPECT_TRUE(report.converged) << "scale " << s << " offset " << offset << " residual "
                                  << report.residual;
  }
  std::vector<double> u = displacement(scene, state);
  for (double& value : u) value /= h;
  return u;
}

TEST(Robustness, TheResultDoesNotDependOnTheUnitOfLength) {
  const std::vector<double> one = dimensionless_result(1, 1e-6);
  for (const double s : {4e-5, 1e-2, 1e3, 4e7})  // h from 1e-6 m to 1e6 m
    EXPECT_LT(relative_difference(dimensionless_result(s, 1e-6), one), 1e-6) << "scale " << s;
}

TEST(Robustness, TheResultDoesNotDependOnThePlace) {
  // 1e6 m away a position carries an error of 1e-10 m, a strain of 5e-9
  const std::vector<double> here = dimensionless_result(1, 1e-4);
  EXPECT_LT(relative_difference(dimensionless_result(1, 1e-4, 1e6), here), 1e-4);
  // the integration reads displacements only: the difference is the rounding of the positions
  EXPECT_LT(relative_difference(dimensionless_result(1, 1e-4, 10), here), 1e-8);
}

TEST(Robustness, DoublingModulusDensityAndLoadsTogetherChangesNothing) {
  const auto run = [](double factor) {
    const Scene scene =
        clamped_beam(10, 3, 3, 0.025, solid(1e5 * factor, 0.4, Law::kNeoHookean, 1000 * factor));
    Solver solver(scene, {});
    State state = initial_state(scene);
    for (int k = 0; k < 5; ++k) EXPECT_TRUE(solver.step(state).converged);
    return displacement(scene, state);
  };
  EXPECT_EQ(run(1), run(2));  // powers of two commute with rounding
}

TEST(Robustness, EveryHourglassModeAndLawRuns) {
  for (const Law law :
       {Law::kFixedCorotated, Law::kNeoHookean, Law::kStableNeoHookean, Law::kStvk, Law::kHencky})
    for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff})
      for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
        Scene scene = clamped_beam(10, 3, 3, 0.025, solid(2e5, 0.3, law));
        scene.hourglass = hourglass;
        finish_scene(scene);
        Solver solver(scene, {.mode = mode});
        State state = initial_state(scene);
        for (int k = 0; k < 4; ++k) {
          const StepReport report = solver.step(state);
          EXPECT_TRUE(report.converged) << law_name(law) << " hourglass " << int(hourglass) << ' '
                                        << solver_name(mode) << " residual " << report.residual;
          EXPECT_EQ(report.energy.hourglass > 0, hourglass != Hourglass::kOff);
        }
      }
}

}  // namespace
}  // namespace elastogen::test
