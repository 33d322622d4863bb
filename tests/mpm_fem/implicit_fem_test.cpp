// SPDX-License-Identifier: Apache-2.0
// Time steps against closed forms and conservation laws.
#include "mpm_fem/integrators/implicit_fem.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "mpm_fem/integrators/modes.hpp"
#include "tests/mpm_fem/scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <complex>
#include <limits>

namespace elastogen::test {
namespace {

using fem::FemState;
using fem::FemStepReport;
using fem::ImplicitFem;
using fem::Mass;
using fem::Scheme;

constexpr Scheme kSchemes[3] = {Scheme::kEuler, Scheme::kBdf2, Scheme::kNewmark};
constexpr const char* kNames[3] = {"Euler", "BDF2", "Newmark"};

/// A beam of 8 x 2 x 2 hexahedra along x, clamped at x = 0, symmetric about its axis.
FemScene beam(double young, Element element = Element::kHex) {
  FemScene scene = box_of(element, 8, 2, 2, 0.05, solid(Law::kFixedCorotated, young, 0.3));
  clamp(scene, 0, 0);
  return scene;
}

FemScene free_block(Element element, double young) {
  return box_of(element, 3, 2, 2, 0.1, solid(Law::kNeoHookean, young, 0.3));
}

/// x.M y
double product(const ImplicitFem& integrator, const Array<double>& x, const Array<double>& y) {
  Array<double> My(y.rows(), 3);
  integrator.potential().mass().multiply(y.data(), My.data());
  double sum = 0;
  for (int64_t k = 0; k < x.size(); ++k) sum += x.data()[k] * My.data()[k];
  return sum;
}

Array<double> shape_of(const fem::Modes& modes, int mode) {
  Array<double> shape(modes.shape.cols() / 3, 3);
  std::copy(modes.shape.row(mode), modes.shape.row(mode) + shape.size(), shape.data());
  return shape;
}

/// A scheme's solution of y' = -i omega y from 1, step by step; theta = omega dt.
std::vector<std::complex<double>> vibration(Scheme scheme, double theta, int steps) {
  const std::complex<double> i(0, 1);
  std::vector<std::complex<double>> y = {1};
  for (int n = 1; n <= steps; ++n) {
    if (scheme == Scheme::kNewmark)
      y.push_back(y[size_t(n) - 1] * (1.0 - i * theta / 2.0) / (1.0 + i * theta / 2.0));
    else if (scheme == Scheme::kEuler || n == 1)
      y.push_back(y[size_t(n) - 1] / (1.0 + i * theta));
    else
      y.push_back((4.0 * y[size_t(n) - 1] - y[size_t(n) - 2]) / (3.0 + 2.0 * i * theta));
  }
  return y;
}

TEST(ImplicitFem, AModeVibratesAsItsSchemeSays) {
  // E2: q + i v/omega of a bending mode, so small that it is linear (bending couples to itself in
  // the third order only); both masses
  for (const Mass mass : {Mass::kLumped, Mass::kConsistent})
    for (int s = 0; s < 3; ++s) {
      FemScene scene = beam(1e6);
      scene.scheme = kSchemes[s];
      scene.mass_kind = mass;
      const fem::Modes modes = vibration_modes(scene, 3);
      const double omega = std::sqrt(modes.omega_squared[0]), theta = 0.3;
      scene.dt = theta / omega;
      ImplicitFem integrator(scene, {.tolerance = 1e-14});
      const Array<double> shape = shape_of(modes, 0);
      FemState state = rest_state(scene);
      const double start = 1e-6;
      for (int64_t k = 0; k < shape.size(); ++k) state.u.data()[k] = start * shape.data()[k];
      const int steps = 60;
      const auto exact = vibration(kSchemes[s], theta, steps);
      double worst = 0;
      for (int n = 1; n <= steps; ++n) {
        ASSERT_TRUE(integrator.step(state).finite);
        const std::complex<double> y(product(integrator, shape, state.u),
                                     product(integrator, shape, state.v) / omega);
        worst = std::max(worst, std::abs(y / start - exact[size_t(n)]));
      }
      printf("%s, %s mass: largest error %.1e of the amplitude, %.3f of it left\n", kNames[s],
             mass == Mass::kLumped ? "lumped" : "consistent", worst, std::abs(exact.back()));
      EXPECT_LT(worst, 1e-8);
    }
}

TEST(ImplicitFem, FreeFallIsExact) {
  // E8: g t (t + dt)/2 for Euler, g t^2/2 for Newmark; BDF2 forgets the error g dt^2/2 of its Euler
  // step as 3/2 (1 - 3^-n)
  for (const Element element : kAllElements)
    for (const Mass mass : {Mass::kLumped, Mass::kConsistent})
      for (int s = 0; s < 3; ++s) {
        FemScene scene = free_block(element, 1e5);
        scene.gravity = {0, -kGravity, 0};
        scene.scheme = kSchemes[s];
        scene.mass_kind = mass;
        ImplicitFem integrator(scene, {.tolerance = 1e-11});
        FemState state = rest_state(scene);
        const int steps = 20;
        for (int k = 0; k < steps; ++k) ASSERT_TRUE(integrator.step(state).converged);
        const double dt = scene.dt, t = steps * dt;
        double fall = kGravity / 2 * t * t;
        if (s == 0) fall += kGravity / 2 * t * dt;
        if (s == 1) fall += kGravity / 2 * dt * dt * 1.5 * (1 - std::pow(3.0, -steps));
        for (int64_t n = 0; n < state.u.rows(); ++n) {
          ASSERT_NEAR(-state.u(n, 1), fall, 1e-12 * fall) << kNames[s] << ' ' << int(mass);
          ASSERT_NEAR(state.u(n, 0), 0, 1e-12);
          ASSERT_NEAR(state.v(n, 1), -kGravity * t, 1e-10);
        }
      }
}

TEST(ImplicitFem, FreeFlightKeepsTheMomentum) {
  // E5: a soft block that flies and spins; a step changes the momentum by dt |sum of the residual|
  for (int s = 0; s < 3; ++s)
    for (const Mass mass : {Mass::kLumped, Mass::kConsistent}) {
      FemScene scene = free_block(Element::kTet10, 2e4);
      scene.scheme = kSchemes[s];
      scene.mass_kind = mass;
      ImplicitFem integrator(scene, {.tolerance = 1e-11});
      FemState state = rest_state(scene);
      const double v[3] = {0.1, -0.2, 0.3}, spin[3] = {3, 4, 5};
      for (int64_t n = 0; n < state.v.rows(); ++n)
        for (int i = 0; i < 3; ++i) {
          const int j = (i + 1) % 3, k = (i + 2) % 3;
          state.v(n, i) = v[i] + spin[j] * scene.mesh.rest(n, k) - spin[k] * scene.mesh.rest(n, j);
        }
      const auto momentum = [&](int i) {
        Array<double> along(state.v.rows(), 3);
        for (int64_t n = 0; n < along.rows(); ++n) along(n, i) = 1;
        return product(integrator, along, state.v);
      };
      const double start[3] = {momentum(0), momentum(1), momentum(2)};
      const int steps = 30;
      for (int k = 0; k < steps; ++k) ASSERT_TRUE(integrator.step(state).converged);
      const double size = std::hypot(start[0], start[1], start[2]);
      const double lost =
          std::hypot(momentum(0) - start[0], momentum(1) - start[1], momentum(2) - start[2]);
      printf("%s: momentum changed by %.1e of it in %d steps\n", kNames[s], lost / size, steps);
      EXPECT_LT(lost, 1e-10 * size);
    }
}

double total_energy(const FemStepReport& report) {
  const EnergyParts& e = report.energy;
  return e.kinetic + e.elastic + e.hourglass + e.gravity;
}

TEST(ImplicitFem, EnergyNeverRisesInImplicitEuler) {
  // E7: a beam falls from rest far beyond small strains and swings
  for (const Element element : kAllElements) {
    FemScene scene = beam(2e4, element);
    scene.gravity = {0, 0, -kGravity};
    ImplicitFem integrator(scene, {.tolerance = 1e-9});
    FemState state = rest_state(scene);
    std::vector<double> energy;
    for (int k = 0; k < 40; ++k) {
      const FemStepReport report = integrator.step(state);
      ASSERT_TRUE(report.converged) << element_name(element) << ' ' << k;
      energy.push_back(total_energy(report));
    }
    const double scale = energy.front() - energy.back();
    double rise = -1e300;
    for (size_t k = 1; k < energy.size(); ++k) rise = std::max(rise, energy[k] - energy[k - 1]);
    printf("%-10s lost %.3e J, largest rise of a step %.1e of it\n",
           std::string(element_name(element)).c_str(), scale, rise / scale);
    EXPECT_LT(rise, 1e-6 * scale) << element_name(element);
  }
}

TEST(ImplicitFem, NewmarkKeepsTheEnergy) {
  // E7: a beam let go swings under its weight for five periods, 80 steps a period
  FemScene scene = beam(1e6);
  scene.gravity = {0, 0, -kGravity};
  scene.scheme = Scheme::kNewmark;
  scene.dt = 1 / (80 * vibration_modes(scene, 1).frequency[0]);
  ImplicitFem integrator(scene);
  FemState state = rest_state(scene);
  double start = 0, swing = 0, drift = 0;
  for (int64_t n = 0; n < state.u.rows(); ++n)
    for (int i = 0; i < 3; ++i)
      start -= integrator.potential().mass().nodal()(n) * scene.gravity[size_t(i)] *
               scene.mesh.rest(n, i);
  for (int k = 0; k < 400; ++k) {
    const FemStepReport report = integrator.step(state);
    ASSERT_TRUE(report.converged);
    ASSERT_EQ(report.used, Scheme::kNewmark);
    drift = std::max(drift, std::abs(total_energy(report) - start));
    swing = std::max(swing, report.energy.kinetic);
  }
  printf("Newmark: energy within %.1e of the largest kinetic energy over 400 steps\n",
         drift / swing);
  EXPECT_LT(drift, 1e-3 * swing);
}

TEST(ImplicitFem, SchemesAreOfTheirOrder) {
  // a weight that comes and goes smoothly, so that the fast vibrations stay at rest
  for (int s = 0; s < 3; ++s) {
    const auto run = [&](int steps) {
      FemScene scene = beam(1e5);
      const Array<double> mass = ElasticBody(scene.mesh, scene.materials).lumped_mass();
      scene.force = [&](double time, Out<double> force) {
        const double pull = kGravity * std::pow(std::sin(5 * time), 4);
        for (int64_t n = 0; n < force.rows; ++n) force(n, 2) = pull * mass(n);
      };
      scene.scheme = kSchemes[s];
      scene.dt = 0.5 / steps;
      ImplicitFem integrator(scene);
      FemState state = rest_state(scene);
      for (int k = 0; k < steps; ++k) EXPECT_TRUE(integrator.step(state).converged);
      return vector_of(state.u);
    };
    const Eigen::VectorXd coarse = run(50), middle = run(100), fine = run(200);
    const double order = std::log2((coarse - middle).norm() / (middle - fine).norm());
    printf("%s: order %.3f in dt\n", kNames[s], order);
    EXPECT_NEAR(order, s == 0 ? 1 : 2, 0.1);
  }
}

TEST(ImplicitFem, APrescribedFlightCarriesTheBodyAlong) {
  // the clamp moves with the velocity that the whole body starts with: nothing bends
  for (int s = 0; s < 3; ++s) {
    FemScene scene = beam(1e5);
    scene.scheme = kSchemes[s];
    const double v[3] = {1, -2, 0.5};
    scene.motion = [&](double time, Out<double> u) {
      for (int64_t n = 0; n < u.rows; ++n)
        for (int i = 0; i < 3; ++i) u(n, i) = v[i] * time;
    };
    ImplicitFem integrator(scene, {.tolerance = 1e-11});
    FemState state = rest_state(scene);
    for (int64_t k = 0; k < state.v.size(); ++k) state.v.data()[k] = v[k % 3];
    for (int k = 0; k < 20; ++k) ASSERT_TRUE(integrator.step(state).converged);
    for (int64_t k = 0; k < state.u.size(); ++k)
      ASSERT_NEAR(state.u.data()[k], v[k % 3] * state.time, 1e-12) << kNames[s];
  }
}

TEST(ImplicitFem, ForcesOnTheNodesAreFelt) {
  // a force m a(t) on every node and nothing else: v' = a(t), Euler takes it at the end of steps
  FemScene scene = free_block(Element::kHex, 1e5);
  const Array<double> mass = ElasticBody(scene.mesh, scene.materials).lumped_mass();
  scene.force = [&](double time, Out<double> force) {
    for (int64_t n = 0; n < force.rows; ++n) force(n, 2) = mass(n) * 3 * time;
  };
  scene.traction = Array<double>(mass.rows(), 3);
  for (int64_t n = 0; n < mass.rows(); ++n) scene.traction(n, 0) = 2 * mass(n);
  ImplicitFem integrator(scene, {.tolerance = 1e-11});
  FemState state = rest_state(scene);
  const int steps = 10;
  for (int k = 0; k < steps; ++k) ASSERT_TRUE(integrator.step(state).converged);
  const double dt = scene.dt;
  for (int64_t n = 0; n < mass.rows(); ++n) {
    ASSERT_NEAR(state.v(n, 2), 3 * dt * dt * steps * (steps + 1) / 2, 1e-12);
    ASSERT_NEAR(state.v(n, 0), 2 * dt * steps, 1e-12);
  }
}

/// The residual of a step by the equations of core/time_scheme.hpp, written out, and the element's
/// own gradient, with its rotations at the start of the step.
double residual_of(const FemScene& scene, const FemState& before, const Array<double>& u) {
  ElasticBody body(scene.mesh, scene.materials);
  body.freeze_rotations(before.u);
  const Array<double> mass = body.lumped_mass();
  Array<double> g(mass.rows(), 3);
  body.add_gradient(u, g);
  const double dt = scene.dt;
  const bool euler = before.u_before.empty();
  double sum = 0, reference = 0;
  for (int64_t n = 0; n < mass.rows(); ++n) {
    if (scene.fixed(n, 0)) continue;
    reference += std::pow(kGravity * mass(n), 2);
    for (int i = 0; i < 3; ++i) {
      const double u1 = before.u(n, i), v1 = before.v(n, i), gravity = scene.gravity[size_t(i)];
      double predicted = u1 + dt * (v1 + dt * gravity);
      if (!euler)
        predicted = (4 * u1 - before.u_before(n, i)) / 3 +
                    2 * dt / 9 * (4 * v1 - before.v_before(n, i)) + 4 * dt * dt / 9 * gravity;
      const double inertia = (euler ? 1 : 2.25) * mass(n) / (dt * dt);
      sum += std::pow(g(n, i) + inertia * (u(n, i) - predicted), 2);
    }
  }
  return std::sqrt(sum / reference);
}

TEST(ImplicitFem, ReportsTheResidualOfTheStateThatItHandsOut) {
  FemScene scene = beam(1e5, Element::kVoxel);
  scene.gravity = {0, 0, -kGravity};
  scene.scheme = Scheme::kBdf2;
  ImplicitFem integrator(scene, {.tolerance = 1e-9});
  FemState state = rest_state(scene);
  for (int k = 0; k < 4; ++k) {
    const FemState before = state;
    const FemStepReport report = integrator.step(state);
    ASSERT_TRUE(report.converged);
    EXPECT_LE(report.residual, 1e-9);
    EXPECT_EQ(report.used, k == 0 ? Scheme::kEuler : Scheme::kBdf2);
    EXPECT_NEAR(residual_of(scene, before, state.u), report.residual, 1e-12);
    double min_j = 1e300;
    const Array<double> F = ElasticBody(scene.mesh, scene.materials).deformation_gradient(state.u);
    for (int64_t e = 0; e < F.rows(); ++e) {
      Mat3<double> matrix;
      std::copy(F.row(e), F.row(e) + 9, matrix.m);
      min_j = std::min(min_j, determinant(matrix));
    }
    EXPECT_NEAR(report.min_j, min_j, 1e-12);
  }
}

TEST(ImplicitFem, HasTheSameBitsOnAnyNumberOfThreads) {
  const auto run = [] {
    FemScene scene = box_of(Element::kTet10, 12, 4, 4, 0.05, solid(Law::kNeoHookean, 1e5, 0.4));
    clamp(scene, 0, 0);
    scene.gravity = {0, 0, -kGravity};
    ImplicitFem integrator(scene);
    FemState state = rest_state(scene);
    for (int k = 0; k < 2; ++k) integrator.step(state);
    return state.u;
  };
  const Array<double> many = run();
  const ThreadLimit limit(1);
  EXPECT_EQ(many, run());
}

TEST(ImplicitFem, RefusesANumberThatIsNotFinite) {
  FemScene scene = beam(1e5);
  ImplicitFem integrator(scene);
  FemState state = rest_state(scene);
  state.v(20, 1) = std::nan("");
  const FemStepReport report = integrator.step(state);
  EXPECT_FALSE(report.finite);
  EXPECT_FALSE(report.converged);
  EXPECT_EQ(state.steps, 0);
  EXPECT_EQ(state.u, rest_state(scene).u);
}

TEST(ImplicitFem, RejectsWhatItsDocumentationForbids) {
  FemScene scene = beam(1e5);
  EXPECT_THROW(ImplicitFem(scene, {.tolerance = 0}), Error);
  ImplicitFem integrator(scene);
  FemState state = rest_state(scene);
  state.v = Array<double>(3, 3);
  EXPECT_THROW(integrator.step(state), Error);
  state = rest_state(scene);
  state.u_before = state.u;
  EXPECT_THROW(integrator.step(state), Error);
  scene.dt = 0;
  EXPECT_THROW(ImplicitFem{scene}, Error);
}

/// The equations are certified on the displacements that positions can hold. Far from the origin,
/// 1e5 m away, these miss a tolerance that displacements by themselves meet.
TEST(ImplicitFem, CertifiesThePositionsThatAreWritten) {
  FemScene scene = beam(1e7);
  for (int64_t n = 0; n < scene.mesh.rest.rows(); ++n) scene.mesh.rest(n, 1) += 1e5;
  scene.gravity = {0, 0, -9.81};
  FemState free = fem::rest_state(scene), written = free;
  ImplicitFem by_displacements(scene, {.tolerance = 1e-7});
  ImplicitFem by_positions(scene, {.tolerance = 1e-7, .as_positions = true});
  const FemStepReport certified = by_displacements.step(free), told = by_positions.step(written);
  EXPECT_TRUE(certified.converged);
  EXPECT_FALSE(told.converged);
  EXPECT_GT(told.residual, 10 * certified.residual);
  double moved = 0;
  for (int64_t k = 0; k < written.u.size(); ++k) {
    const double rest = scene.mesh.rest.data()[k], u = written.u.data()[k];
    EXPECT_EQ(rest + u - rest, u);
    moved = std::max(moved, std::abs(u - free.u.data()[k]));
  }
  EXPECT_GT(moved, 0);
  EXPECT_LE(moved, 1e5 * std::numeric_limits<double>::epsilon());
}

}  // namespace
}  // namespace elastogen::test
