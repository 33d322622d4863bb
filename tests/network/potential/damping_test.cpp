// SPDX-License-Identifier: Apache-2.0
// The viscous part of the incremental potential: derivatives, and what it must not feel.
#include "network/potential/incremental_potential.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace elastogen::test {
namespace {

constexpr double kDampedEdge = 0.1;  // voxels of all scenes here [m]

/// A ragged block of a damped and an undamped material.
Scene damped_block(Hourglass hourglass, double loss = 0.3) {
  Scene scene = scene_on(ragged_grid(9, 7, 6, kDampedEdge, 11), solid(1e5, 0.3));
  scene.materials[0].loss_factor = loss;
  scene.materials[0].loss_frequency = 4;
  scene.materials.push_back(solid(3e4, 0.45, Law::kNeoHookean, 700));
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v) scene.material(v) = int32_t(v / 3 % 2);
  scene.hourglass = hourglass;
  finish_scene(scene);
  return scene;
}

/// Rest displaced at random by `noise`, then turned about z by `angle`.
State turned_state(const Scene& scene, double noise, double angle, uint32_t seed) {
  State state = initial_state(scene);
  const std::vector<double> random = random_field(scene, noise, seed);
  const double c = std::cos(angle), s = std::sin(angle);
  for (int64_t n = 0; n < state.x.rows(); ++n) {
    double p[3];
    for (int d = 0; d < 3; ++d) p[d] = state.x(n, d) + random[size_t(3 * n + d)];
    state.x(n, 0) = c * p[0] - s * p[1];
    state.x(n, 1) = s * p[0] + c * p[1];
    state.x(n, 2) = p[2];
  }
  return state;
}

/// D and its gradient at u, as the difference of the potential and that of the same scene without
/// damping.
struct Viscous {
  PotentialValue value;
  std::vector<double> gradient;
};

Viscous viscous_part(const Scene& scene, const State& start, const std::vector<double>& u) {
  const StepScheme scheme = step_scheme(scene, start);
  Scene elastic = scene;
  for (Material& m : elastic.materials) m.loss_factor.reset();
  IncrementalPotential with(scene), without(elastic);
  with.begin_step(start, scheme);
  without.begin_step(start, scheme);
  Viscous result;
  result.gradient.resize(u.size());
  std::vector<double> rest(u.size());
  result.value = with.evaluate<double>(u.data(), result.gradient.data());
  without.evaluate<double>(u.data(), rest.data());
  for (size_t k = 0; k < u.size(); ++k) result.gradient[k] -= rest[k];
  return result;
}

TEST(Damping, GradientIsTheDerivativeOfTheValue) {
  for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff}) {
    const Scene scene = damped_block(hourglass);
    const State start = turned_state(scene, 0.1 * kDampedEdge, 0.7, 21);
    const std::vector<double> u =
        displacement(scene, turned_state(scene, 0.1 * kDampedEdge, 1, 22));
    const std::vector<double> p = random_field(scene, kDampedEdge, 23);
    const Viscous at = viscous_part(scene, start, u);
    ASSERT_GT(at.value.viscous, 0);
    std::vector<double> high = u, low = u;
    const double e = 1e-6;
    for (size_t k = 0; k < u.size(); ++k) high[k] += e * p[k], low[k] -= e * p[k];
    const double slope = (viscous_part(scene, start, high).value.viscous -
                          viscous_part(scene, start, low).value.viscous) /
                         (2 * e);
    EXPECT_NEAR(slope, dot(at.gradient, p), 1e-7 * norm(at.gradient) * norm(p));
  }
}

/// A p in float at u against differences of the gradient along p in double.
void expect_derivative(const Scene& scene, const State& start, const std::vector<double>& u,
                       TangentKind kind) {
  const std::vector<double> p = random_field(scene, 1, 32);
  IncrementalPotential potential(scene);
  potential.begin_step(start, step_scheme(scene, start));
  const std::vector<float> direction(p.begin(), p.end());
  std::vector<float> product(p.size());
  potential.linearise(u.data(), kind);
  potential.hessian_product(direction.data(), product.data());
  std::vector<double> high = u, low = u, above(u.size()), below(u.size());
  const double e = 1e-7;
  for (size_t k = 0; k < u.size(); ++k) high[k] += e * p[k], low[k] -= e * p[k];
  potential.evaluate<double>(high.data(), above.data());
  potential.evaluate<double>(low.data(), below.data());
  for (size_t k = 0; k < u.size(); ++k) above[k] = (above[k] - below[k]) / (2 * e);
  EXPECT_LT(relative_difference(product, above), 1e-4);
}

TEST(Damping, HessianIsTheDerivativeOfTheGradient) {
  // without the part within a voxel, whose Hessian is that of small strain
  const Scene scene = damped_block(Hourglass::kOff);
  expect_derivative(scene, turned_state(scene, 0.02 * kDampedEdge, 0.7, 21),
                    displacement(scene, turned_state(scene, 0.05 * kDampedEdge, 0.8, 22)),
                    TangentKind::kTrue);
}

TEST(Damping, HessianWithinAVoxelIsThatOfSmallStrain) {
  const Scene scene = damped_block(Hourglass::kVariance);
  const State start = turned_state(scene, 0, 0.7, 21);
  expect_derivative(scene, start, displacement(scene, start), TangentKind::kProjected);
}

TEST(Damping, DoesNotFeelThatABodyTurns) {
  for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kOff}) {
    const Scene scene = damped_block(hourglass);
    const State start = turned_state(scene, 0.1 * kDampedEdge, 0, 21);
    const std::vector<double> u =
        displacement(scene, turned_state(scene, 0.1 * kDampedEdge, 1.2, 21));
    const Viscous same = viscous_part(scene, start, u);
    const Viscous other = viscous_part(
        scene, start, displacement(scene, turned_state(scene, 0.1 * kDampedEdge, 0, 5)));
    EXPECT_LT(same.value.viscous, 1e-25 * other.value.viscous);
    EXPECT_LT(norm(same.gradient), 1e-12 * norm(other.gradient));
  }
}

TEST(Damping, HasNeitherForceNorTorqueOnTheBody) {
  const Scene scene = damped_block(Hourglass::kFull);
  const State start = turned_state(scene, 0.1 * kDampedEdge, 0, 21);
  const State end = turned_state(scene, 0.1 * kDampedEdge, 0.4, 22);
  const Viscous at = viscous_part(scene, start, displacement(scene, end));
  double force[3] = {}, torque[3] = {}, sum = 0;
  for (int64_t n = 0; n < end.x.rows(); ++n) {
    const double *x = end.x.row(n), *f = at.gradient.data() + 3 * n;
    sum += std::hypot(f[0], f[1], f[2]);
    for (int i = 0; i < 3; ++i) {
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      force[i] += f[i];
      torque[i] += x[j] * f[k] - x[k] * f[j];
    }
  }
  EXPECT_GT(sum, 0);
  EXPECT_LT(std::hypot(force[0], force[1], force[2]), 1e-10 * sum);
  EXPECT_LT(std::hypot(torque[0], torque[1], torque[2]), 1e-10 * sum * 9 * kDampedEdge);
}

TEST(Damping, OfAHomogeneousStretchIsThatOfTheFormula) {
  // (1 + s) along x in one Euler step: E' = (s + s^2/2) / dt
  Scene scene = scene_on(make_box(3, 3, 3, kDampedEdge), solid(1e5, 0.3));
  scene.materials[0].loss_factor = 0.2;
  scene.materials[0].loss_frequency = 5;
  finish_scene(scene);
  const State start = initial_state(scene);
  std::vector<double> u(size_t(start.x.size()));
  const double s = 0.1;
  for (int64_t n = 0; n < start.x.rows(); ++n) u[size_t(3 * n)] = s * start.x(n, 0);
  const double strain = s + s * s / 2, tau = 0.2 / (2 * std::numbers::pi * 5);
  const Material& m = scene.materials[0];
  const double expected =
      27 * std::pow(kDampedEdge, 3) * tau / scene.dt * (m.mu() + m.lambda() / 2) * strain * strain;
  EXPECT_NEAR(viscous_part(scene, start, u).value.viscous, expected, 1e-12 * expected);
}

}  // namespace
}  // namespace elastogen::test
