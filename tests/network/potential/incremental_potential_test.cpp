// SPDX-License-Identifier: Apache-2.0
#include "network/potential/incremental_potential.hpp"

#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

constexpr double kSceneH = 0.1;  // voxel edge of all scenes here [m]
const Law kLaws[] = {Law::kFixedCorotated, Law::kNeoHookean, Law::kStableNeoHookean, Law::kStvk,
                     Law::kHencky};

/// A ragged block over several bricks, pinned on one side, of two materials of one law.
Scene ragged_scene(Law law, TimeScheme scheme, Hourglass hourglass) {
  Scene scene = scene_on(ragged_grid(9, 7, 6, kSceneH, 11), solid(1e5, 0.3, law));
  scene.materials.push_back(solid(3e4, 0.45, law, 700));
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v) scene.material(v) = int32_t(v / 3 % 2);
  pin_below(scene, 0, -1.5 * kSceneH);
  scene.gravity = {1, -9.81, 2};
  scene.scheme = scheme;
  scene.hourglass = hourglass;
  return scene;
}

/// A possible start of a step: turned by 0.7 rad about (2, -1, 2)/3 and disturbed.
State moved_state(const Scene& scene, double noise) {
  State state = initial_state(scene);
  const double s = std::sin(0.7), c = 1 - std::cos(0.7), a[3] = {2.0 / 3, -1.0 / 3, 2.0 / 3};
  const Mat3<double> K = {{0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0}};
  const Mat3<double> K2 = K * K;
  const std::vector<double> random = random_field(scene, noise, 21);
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    const double* X = scene.grid.rest.row(n);
    for (int i = 0; i < 3; ++i) {
      double turned = X[i];
      for (int j = 0; j < 3; ++j) turned += (s * K(i, j) + c * K2(i, j)) * X[j];
      state.x(n, i) = turned + random[size_t(3 * n + i)];
      state.v(n, i) = 10 * random[size_t(3 * n + i)];
    }
  }
  state.x_before = state.x;
  state.v_before = state.v;
  for (int64_t k = 0; k < state.x.size(); ++k) state.x_before.data()[k] -= 1e-3 * random[size_t(k)];
  return state;
}

/// A floor away from the pins, so high that the deepest surface point keeps a third of the layer at
/// the state.
void put_floor(Scene& scene, const State& state, double friction) {
  scene.surface = face_points(scene.grid);
  const Vec3 normal = {-0.8, 0.6, 0};
  double lowest = 1e300;
  for (int64_t p = 0; p < scene.surface.voxel.rows(); ++p) {
    double height = 0;
    for (int c = 0; c < 8; ++c)
      for (int i = 0; i < 3; ++i)
        height += scene.surface.weights(p, c) * normal[size_t(i)] *
                  state.x(scene.grid.corners(scene.surface.voxel(p), c), i);
    lowest = std::min(lowest, height);
  }
  scene.colliders = {half_space(normal, lowest + 2.0 / 3 * kSceneH / 4, friction)};
}

StepScheme scheme_of(const Scene& scene, const State& state) {
  return step_scheme(scene, state);
}

/// |(Phi(u + e p) - Phi(u - e p)) / 2e - g.p| / (|g| |p|)
double gradient_error(IncrementalPotential& potential, const std::vector<double>& u,
                      const std::vector<double>& p, double step) {
  std::vector<double> g(u.size()), scratch(u.size()), plus = u, minus = u;
  potential.evaluate<double>(u.data(), g.data());
  for (size_t k = 0; k < u.size(); ++k) plus[k] += step * p[k], minus[k] -= step * p[k];
  const double high = potential.evaluate<double>(plus.data(), scratch.data()).total();
  const double low = potential.evaluate<double>(minus.data(), scratch.data()).total();
  return std::abs((high - low) / (2 * step) - dot(g, p)) / (norm(g) * norm(p));
}

TEST(IncrementalPotential, GradientIsTheDerivativeOfTheValue) {
  for (const Law law : kLaws)
    for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kBdf2})
      for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff})
        for (const bool contact : {false, true}) {
          Scene scene = ragged_scene(law, scheme, hourglass);
          finish_scene(scene);
          const State state = moved_state(scene, 0.02 * kSceneH);
          if (contact) put_floor(scene, state, 0.4);
          IncrementalPotential potential(scene);
          potential.begin_step(state, scheme_of(scene, state));
          std::vector<double> u = displacement(scene, state);
          const std::vector<double> away = random_field(scene, 0.02 * kSceneH, 22);
          for (size_t k = 0; k < u.size(); ++k) u[k] += away[k];
          std::vector<double> g(u.size());
          const PotentialValue value = potential.evaluate<double>(u.data(), g.data());
          ASSERT_TRUE(std::isfinite(value.total()));
          EXPECT_EQ(value.contact > 0, contact);
          EXPECT_EQ(value.hourglass > 0, hourglass != Hourglass::kOff);
          EXPECT_LT(gradient_error(potential, u, random_field(scene, kSceneH, 23), 1e-6), 1e-7)
              << law_name(law) << " scheme " << int(scheme) << " hourglass " << int(hourglass)
              << " contact " << contact;
        }
}

TEST(IncrementalPotential, GradientOfContactAndFrictionAloneIsTheDerivative) {
  // soft and light, so that the contact is not hidden behind the rest
  Scene scene = ragged_scene(Law::kNeoHookean, TimeScheme::kEuler, Hourglass::kFull);
  finish_scene(scene);
  const State state = moved_state(scene, 0.02 * kSceneH);
  put_floor(scene, state, 0.7);
  Contact contact(scene);
  std::vector<double> u = displacement(scene, state);
  contact.begin_step(u.data());
  const std::vector<double> away = random_field(scene, 0.02 * kSceneH, 24),
                            p = random_field(scene, 1, 25);
  for (size_t k = 0; k < u.size(); ++k) u[k] += away[k];
  std::vector<double> g(u.size()), plus = u, minus = u;
  contact.evaluate(u.data(), g.data());
  const double e = 1e-8;
  for (size_t k = 0; k < u.size(); ++k) plus[k] += e * p[k], minus[k] -= e * p[k];
  const double slope = (contact.evaluate<double>(plus.data(), nullptr) -
                        contact.evaluate<double>(minus.data(), nullptr)) /
                       (2 * e);
  EXPECT_GT(norm(g), 0);
  EXPECT_NEAR(slope, dot(g, p), 1e-6 * norm(g) * norm(p));
}

TEST(IncrementalPotential, FloatAndDoubleAgreeToTheDigitsOfFloat) {
  for (const Law law : kLaws) {
    Scene scene = ragged_scene(law, TimeScheme::kEuler, Hourglass::kFull);
    finish_scene(scene);
    const State state = moved_state(scene, 0.02 * kSceneH);
    IncrementalPotential potential(scene);
    potential.begin_step(state, scheme_of(scene, state));
    const std::vector<double> u = displacement(scene, state);
    std::vector<double> precise(u.size());
    std::vector<float> single(u.size());
    const PotentialValue a = potential.evaluate<double>(u.data(), precise.data());
    const PotentialValue b = potential.evaluate<float>(u.data(), single.data());
    EXPECT_LT(relative_difference(single, precise), 2e-5) << law_name(law);
    EXPECT_NEAR(b.total() / a.total(), 1, 2e-5);
    EXPECT_NEAR(b.min_j, a.min_j, 1e-5);
  }
}

/// Stretched by 2 % in each direction: every eigenvalue of the tangent is positive.
State stretched_state(const Scene& scene) {
  State state = initial_state(scene);
  const std::vector<double> random = random_field(scene, 0.002 * kSceneH, 31);
  for (int64_t k = 0; k < state.x.size(); ++k)
    state.x.data()[k] += 0.02 * scene.grid.rest.data()[k] + random[size_t(k)];
  return state;
}

/// A p in float against differences of the gradient along p, in double.
void expect_derivative_of_gradient(IncrementalPotential& potential, const std::vector<double>& u,
                                   TangentKind kind) {
  const std::vector<double> p = random_field(potential.scene(), 1, 32);
  const std::vector<float> direction(p.begin(), p.end());
  std::vector<float> product(p.size());
  potential.linearise(u.data(), kind);
  potential.hessian_product(direction.data(), product.data());
  std::vector<double> plus = u, minus = u, high(u.size()), low(u.size());
  const double e = 1e-9;  // below the slip range of friction, where the Hessian is exact
  for (size_t k = 0; k < u.size(); ++k) plus[k] += e * p[k], minus[k] -= e * p[k];
  potential.evaluate<double>(plus.data(), high.data());
  potential.evaluate<double>(minus.data(), low.data());
  for (size_t k = 0; k < u.size(); ++k) high[k] = (high[k] - low[k]) / (2 * e);
  EXPECT_LT(relative_difference(product, high), 1e-4);
}

TEST(IncrementalPotential, HessianIsTheDerivativeOfTheGradientWhereNothingIsProjected) {
  for (const Law law : kLaws)
    for (const bool contact : {false, true}) {
      SCOPED_TRACE(law_name(law));
      SCOPED_TRACE(contact ? "contact" : "no contact");
      Scene scene = ragged_scene(law, TimeScheme::kEuler, Hourglass::kFull);
      finish_scene(scene);
      const State state = stretched_state(scene);
      if (contact) put_floor(scene, state, 0.4);
      IncrementalPotential potential(scene);
      potential.begin_step(state, scheme_of(scene, state));
      expect_derivative_of_gradient(potential, displacement(scene, state), TangentKind::kProjected);
    }
}

TEST(IncrementalPotential, TrueHessianIsTheDerivativeOfTheGradientUnderCompression) {
  for (const Law law : kLaws) {
    SCOPED_TRACE(law_name(law));
    Scene scene = ragged_scene(law, TimeScheme::kEuler, Hourglass::kFull);
    finish_scene(scene);
    State state = stretched_state(scene);
    for (int64_t n = 0; n < state.x.rows(); ++n) state.x(n, 0) *= 0.7;
    IncrementalPotential potential(scene);
    potential.begin_step(state, scheme_of(scene, state));
    expect_derivative_of_gradient(potential, displacement(scene, state), TangentKind::kTrue);
  }
}

TEST(IncrementalPotential, RestHessianIsTheHessianAtRest) {
  for (const Law law : kLaws)
    for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff}) {
      Scene scene = ragged_scene(law, TimeScheme::kEuler, hourglass);
      finish_scene(scene);
      const State state = initial_state(scene);
      IncrementalPotential potential(scene);
      potential.begin_step(state, scheme_of(scene, state));
      const std::vector<double> zero(size_t(state.x.size())), p = random_field(scene, 1, 33);
      const std::vector<float> direction(p.begin(), p.end());
      std::vector<float> frozen(p.size());
      std::vector<double> rest(p.size());
      potential.linearise(zero.data());
      potential.hessian_product(direction.data(), frozen.data());
      potential.rest_hessian_product(p.data(), rest.data());
      EXPECT_LT(relative_difference(frozen, rest), 1e-5) << law_name(law);
    }
}

TEST(IncrementalPotential, HessiansAreSymmetricAndPositive) {
  Scene scene = ragged_scene(Law::kNeoHookean, TimeScheme::kEuler, Hourglass::kFull);
  finish_scene(scene);
  const State state =
      moved_state(scene, 0.1 * kSceneH);  // compressed in places: projection at work
  put_floor(scene, state, 0.4);
  IncrementalPotential potential(scene);
  potential.begin_step(state, scheme_of(scene, state));
  const std::vector<double> u = displacement(scene, state);
  const std::vector<double> p = random_field(scene, 1, 34), q = random_field(scene, 1, 35);
  std::vector<double> Ap(p.size()), Aq(p.size());
  // the operator at rest
  potential.rest_hessian_product(p.data(), Ap.data());
  potential.rest_hessian_product(q.data(), Aq.data());
  EXPECT_NEAR(dot(q, Ap), dot(p, Aq), 1e-13 * norm(q) * norm(Ap));
  EXPECT_GT(dot(p, Ap), 0);

  // the projected Hessian, in float
  const std::vector<float> pf(p.begin(), p.end()), qf(q.begin(), q.end());
  std::vector<float> product(p.size());
  potential.linearise(u.data());
  potential.hessian_product(pf.data(), product.data());
  Ap.assign(product.begin(), product.end());
  potential.hessian_product(qf.data(), product.data());
  Aq.assign(product.begin(), product.end());
  EXPECT_NEAR(dot(q, Ap), dot(p, Aq), 1e-6 * norm(q) * norm(Ap));
  EXPECT_GT(dot(p, Ap), 0);
}

/// Gradient without inertia: the internal force, with its sign turned.
std::vector<double> internal_force(const Scene& scene, IncrementalPotential& potential,
                                   const std::vector<double>& u) {
  std::vector<double> g(u.size());
  potential.evaluate<double>(u.data(), g.data());
  for (size_t k = 0; k < u.size(); ++k)
    if (!scene.pinned(int64_t(k / 3)))
      g[k] -= potential.inertia(int64_t(k / 3)) * (u[k] - potential.predictor()[k]);
  return g;
}

TEST(IncrementalPotential, NetForceAndTorqueAreZeroInRandomStates) {
  for (const Hourglass hourglass : {Hourglass::kFull, Hourglass::kVariance, Hourglass::kOff}) {
    // a free body without gravity
    Scene scene = ragged_scene(Law::kNeoHookean, TimeScheme::kEuler, hourglass);
    scene.pinned.fill(0);
    scene.dt = 10;  // hardly any inertia: nothing to subtract
    scene.gravity = {};
    finish_scene(scene);
    State state = moved_state(scene, 0.1 * kSceneH);
    state.v.fill(0);
    IncrementalPotential potential(scene);
    potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
    const std::vector<double> f = internal_force(scene, potential, displacement(scene, state));
    // sums of forces and of their moments
    double force[3] = {}, torque[3] = {}, sum = 0;
    for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
      const double* x = state.x.row(n);
      const double* fn = f.data() + 3 * n;
      sum += std::hypot(fn[0], fn[1], fn[2]);
      for (int i = 0; i < 3; ++i) {
        const int j = (i + 1) % 3, k = (i + 2) % 3;
        force[i] += fn[i];
        torque[i] += x[j] * fn[k] - x[k] * fn[j];
      }
    }
    const double size = 9 * kSceneH;
    EXPECT_LT(std::hypot(force[0], force[1], force[2]), 1e-12 * sum);
    // only the frozen torsion correction has a torque
    const double share = std::hypot(torque[0], torque[1], torque[2]) / (sum * size);
    if (hourglass == Hourglass::kFull)
      printf("torque of the frozen torsion correction: %.1e of sum |f| times the size\n", share);
    else
      EXPECT_LT(share, 1e-12);
  }
}

TEST(IncrementalPotential, RigidMotionCostsNothing) {
  for (const double far : {0.0, 1e6}) {
    Scene scene = ragged_scene(Law::kHencky, TimeScheme::kEuler, Hourglass::kFull);
    scene.pinned.fill(0);
    finish_scene(scene);
    State state = moved_state(scene, 0);
    IncrementalPotential potential(scene);
    potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
    std::vector<double> u = displacement(scene, state);
    for (double& value : u) value += far * 9 * kSceneH;
    const double noise = 1 + far;  // position noise eps |X| becomes strain eps |X| / h
    std::vector<double> g(u.size());
    const PotentialValue value = potential.residual(u.data(), g.data());
    EXPECT_LT(value.elastic + value.hourglass,
              1e-20 * noise * noise * 1e5 * kSceneH * kSceneH * kSceneH);
    EXPECT_NEAR(value.min_j, 1, 1e-13 * noise);
    EXPECT_NEAR(value.min_corner_j, 1, 1e-13 * noise);
    if (far > 0) continue;
    for (const double f : internal_force(scene, potential, u))
      ASSERT_LT(std::abs(f), 1e-10 * 1e5 * kSceneH * kSceneH);
  }
}

TEST(IncrementalPotential, HomogeneousStrainHasTheEnergyOfTheLawTimesTheFilledVolume) {
  Scene scene = scene_on(ragged_grid(9, 7, 6, kSceneH, 12), solid(1e5, 0.3));
  finish_scene(scene);
  State state = initial_state(scene);
  // x = F X at all nodes
  const double F[3][3] = {{1.2, 0.1, -0.05}, {0.02, 0.9, 0.15}, {0.05, -0.1, 1.1}};
  double volume = 0, I = 0;
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
    volume += scene.grid.fill(v) * kSceneH * kSceneH * kSceneH;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    for (int i = 0; i < 3; ++i) {
      state.x(n, i) = 0;
      for (int j = 0; j < 3; ++j) state.x(n, i) += F[i][j] * scene.grid.rest(n, j);
    }
  // the energy density of the law, written out
  for (const auto& row : F)
    for (const double f : row) I += f * f;
  const double J = F[0][0] * (F[1][1] * F[2][2] - F[1][2] * F[2][1]) -
                   F[0][1] * (F[1][0] * F[2][2] - F[1][2] * F[2][0]) +
                   F[0][2] * (F[1][0] * F[2][1] - F[1][1] * F[2][0]);
  const double mu = 1e5 / 2.6, lambda = 1e5 * 0.3 / (1.3 * 0.4), l = std::log(J);
  const double psi = mu / 2 * (I - 3) - mu * l + lambda / 2 * l * l;
  // the potential has it times the filled volume
  IncrementalPotential potential(scene);
  potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
  const std::vector<double> u = displacement(scene, state);
  std::vector<double> g(u.size());
  const PotentialValue value = potential.residual(u.data(), g.data());
  EXPECT_NEAR(value.elastic / (psi * volume), 1, 1e-12);
  EXPECT_LT(value.hourglass, 1e-12 * value.elastic);
  EXPECT_NEAR(value.min_j, J, 1e-12);
  EXPECT_NEAR(value.min_corner_j, J, 1e-12);
}

/// Tables of nets may give a body at rest an energy a few digits below 0.
TEST(IncrementalPotential, NoiseIsThatOfEnergiesOfEitherSign) {
  Scene scene = scene_on(ragged_grid(9, 7, 6, kSceneH, 12), solid(1e5, 0.3));
  finish_scene(scene);
  const IncrementalPotential potential(scene);
  PotentialValue above, below;
  above.elastic = 1e-10, below.elastic = -1e-10;
  EXPECT_GT(potential.noise(below, 1e-16), 0);
  EXPECT_EQ(potential.noise(below, 1e-16), potential.noise(above, 1e-16));
}

}  // namespace
}  // namespace elastogen::test
