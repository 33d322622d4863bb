// SPDX-License-Identifier: Apache-2.0
// Finite elements on voxels that pins cut: the bar of tests/network/step/held_test.cpp, 1 x 0.2 x 0.2 m
// with a hundredth of its length held at both ends, against its reference and against the network.
#include "mpm_fem/integrators/implicit_fem.hpp"
#include "mpm_fem/integrators/modes.hpp"
#include "mpm_fem/integrators/parted_fem.hpp"
#include "mpm_fem/integrators/static_fem.hpp"
#include "tests/mpm_fem/stage_scenes.hpp"
#include "tests/network/held_scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

using fem::Element;
using fem::FemScene;
using fem::FemState;

constexpr double kBarEdge = 0.05;               // of a voxel: four across the bar
constexpr double kSagUnit = 1000 * 9.81 / 1e8;  // of displacements, for those of weight 1 and E 1
constexpr double kQuarter = -0.64436, kMiddle = -1.0588;  // sag of the reference

/// A bar held below x = 0.01 and above x = end, its left border an offset [voxels] behind a layer of
/// nodes; across it the grid fits or does not.
Scene held_bar(double offset, double dt = 100, double end = 0.99, double across = 0.02) {
  return held_scene(box_surface({0, 0, 0}, {end + 0.01, 0.2, 0.2}),
                    {half_space_border(true, 0.01), half_space_border(false, end)}, kBarEdge,
                    {0.01 - offset * kBarEdge, across, across}, dt);
}

Array<double> at(const Scene& scene, const FemScene& body, const Array<double>& u,
                 const std::vector<Vec3>& points) {
  FemState state = fem::rest_state(body);
  state.u = u;
  return displacements(scene, as_positions(body, state), points);
}

/// Sags at a quarter, the middle and three quarters, the motion of both held faces, what the forces
/// that hold the bar are of its weight, and the moment that both leave, of the weight times 1 m.
struct Sag {
  double quarter = 0, middle = 0, other = 0, faces = 0, reaction = 0, moment = 0;
};

Sag sag_of(const Scene& scene, Element element, double length) {
  const FemScene body = as_fem(scene, element);
  const fem::StaticResult result = solve_static(body, {.tolerance = 1e-9});
  EXPECT_TRUE(result.converged);
  EXPECT_TRUE(scene.dependent.empty() || result.increments == 1);
  const double left = 0.01, right = 0.01 + length;
  const Array<double> u = at(scene, body, result.u,
                             {{left + 0.24 / 0.98 * length, 0.1, 0.1},
                              {left + length / 2, 0.1, 0.1},
                              {right - 0.24 / 0.98 * length, 0.1, 0.1},
                              {left, 0.05, 0.13},
                              {right, 0.19, 0.01}});
  Sag sag{u(0, 1) / kSagUnit, u(1, 1) / kSagUnit, u(2, 1) / kSagUnit};
  for (int p = 3; p < 5; ++p)
    for (int d = 0; d < 3; ++d) sag.faces = std::max(sag.faces, std::abs(u(p, d)) / kSagUnit);
  // the forces that hold it
  double weight = 0;
  for (int64_t n = 0; n < scene.mass.rows(); ++n) weight += 9.81 * scene.mass(n);
  for (int64_t n = 0; n < scene.mass.rows(); ++n) {
    sag.reaction += result.reaction(n, 1) / weight;
    const double x = body.mesh.rest(n, 0) + result.u(n, 0),
                 y = body.mesh.rest(n, 1) + result.u(n, 1);
    const double up = result.reaction(n, 1) - 9.81 * scene.mass(n);
    sag.moment += (x * up - y * result.reaction(n, 0)) / weight;
  }
  return sag;
}

TEST(HeldFem, SagsAlikeOnAnyGridAndAtBothEnds) {
  double least = 1e300, most = 0;
  for (const double offset : {0.0, 1e-4, 0.1, 0.3, 0.5, 0.7, 0.9, 0.9999}) {
    const Sag sag = sag_of(held_bar(offset), Element::kVoxel, 0.98);
    EXPECT_NEAR(sag.middle / kMiddle, 1 - 0.0348, 0.01) << offset;  // the error of a grid that fits
    EXPECT_NEAR(sag.quarter / kQuarter, 1 - 0.0348, 0.01) << offset;
    EXPECT_LT(std::abs(sag.quarter - sag.other), 0.005 * std::abs(sag.middle)) << offset;
    EXPECT_LT(sag.faces, 1e-6 * std::abs(sag.middle)) << offset;
    EXPECT_NEAR(sag.reaction, 1, 1e-6) << offset;
    EXPECT_NEAR(sag.moment, 0, 1e-6) << offset;
    least = std::min(least, -sag.middle);
    most = std::max(most, -sag.middle);
    printf("voxel, offset %.4f: sag %.4f of the reference, left-right %.3f %%\n", offset,
           sag.middle / kMiddle, 100 * std::abs((sag.quarter - sag.other) / sag.middle));
  }
  EXPECT_LT(most, 1.015 * least);
}

TEST(HeldFem, OfGaussPointsSagAsOnAGridThatFits) {
  for (const Element element : {Element::kHex, Element::kHexBbar}) {
    const Sag fit = sag_of(held_bar(0, 100, 1.01, 0), element, 1);
    double least = 1e300, most = 0;
    for (const double offset : {1e-4, 0.1, 0.3, 0.5, 0.7, 0.9, 0.9999}) {
      const Sag sag = sag_of(held_bar(offset, 100, 1.01, 0), element, 1);
      EXPECT_NEAR(sag.middle / fit.middle, 1, 0.01) << offset;
      EXPECT_LT(std::abs(sag.quarter - sag.other), 0.005 * std::abs(sag.middle)) << offset;
      EXPECT_LT(sag.faces, 1e-6 * std::abs(sag.middle)) << offset;
      EXPECT_NEAR(sag.reaction, 1, 1e-6) << offset;
      EXPECT_NEAR(sag.moment, 0, 1e-6) << offset;
      least = std::min(least, -sag.middle);
      most = std::max(most, -sag.middle);
      printf("%s, offset %.4f: %.4f of the sag on a grid that fits, left-right %.3f %%\n",
             element_name(element).data(), offset, sag.middle / fit.middle,
             100 * std::abs((sag.quarter - sag.other) / sag.middle));
    }
    EXPECT_LT(most, 1.015 * least);
  }
}

TEST(HeldFem, PointsOfGaussLieInTheFreePart) {
  const Scene scene = held_bar(0.3, 100, 1.01, 0);
  const fem::ElementMesh mesh = voxel_mesh(scene, Element::kHex);
  constexpr double kMargin = 1e-6;  // of fills, in voxels
  int cut = 0;
  for (int64_t v = 0; v < mesh.part.rows(); ++v) {
    const double* box = mesh.part.row(v);
    const double X = mesh.rest(mesh.elements(v, 0), 0);
    EXPECT_NEAR(box[0], std::clamp((0.01 - X) / kBarEdge, 0.0, 1.0), kMargin);
    EXPECT_NEAR(box[3], std::clamp((1.01 - X) / kBarEdge, 0.0, 1.0), kMargin);
    for (const int d : {1, 2}) {
      EXPECT_NEAR(box[d], 0, kMargin);
      EXPECT_NEAR(box[3 + d], 1, kMargin);
    }
    cut += box[3] - box[0] < 1 - kMargin;
  }
  EXPECT_EQ(cut, 32);
}

TEST(HeldFem, StandsWhereTheNetworkStands) {
  for (const double offset : {0.3, 0.97}) {
    const Scene scene = held_bar(offset, 1000);
    const FemScene body = as_fem(scene);
    const fem::StaticResult result = solve_static(body, {.tolerance = 1e-10});
    const State state = equilibrium(scene, nullptr, 1e-9);
    double most = 0, off = 0;
    for (int64_t k = 0; k < result.u.size(); ++k) {
      const double u = state.x.data()[k] - body.mesh.rest.data()[k];
      most = std::max(most, std::abs(u));
      off = std::max(off, std::abs(u - result.u.data()[k]));
    }
    printf("statics against the network, offset %.2f: %.2g of the sag\n", offset, off / most);
    EXPECT_LT(off, 1e-5 * most);
  }
}

fem::Scheme same(TimeScheme scheme) {
  switch (scheme) {
    case TimeScheme::kBdf2:
      return fem::Scheme::kBdf2;
    case TimeScheme::kSdirk2:
      return fem::Scheme::kSdirk2;
    case TimeScheme::kAuto:
      return fem::Scheme::kAuto;
    default:
      return fem::Scheme::kEuler;
  }
}

/// Plays finite elements to a time, from rest.
FemState swung(FemScene body, fem::Scheme scheme, double end, double tolerance,
               fem::LinearOptions linear = {}) {
  body.scheme = scheme;
  FemState state = fem::rest_state(body);
  const fem::ImplicitOptions solve{.tolerance = tolerance, .linear = linear, .as_positions = true};
  std::optional<fem::ImplicitFem> steps;
  std::optional<fem::StageFem> stages;
  if (scheme == fem::Scheme::kSdirk2 || scheme == fem::Scheme::kAuto)
    stages.emplace(body, fem::StageOptions{.solve = solve, .follows_time_error = false});
  else
    steps.emplace(body, solve);
  while (state.time < end * (1 - 1e-9)) {
    const fem::FemStepReport report = stages ? stages->step(state) : steps->step(state);
    EXPECT_TRUE(report.converged) << report.residual;
    if (!report.converged) break;
  }
  // the state meets the constraints, to the rounding of positions
  Array<double> u = state.u, v = state.v;
  body.dependent.fill(u.data());
  body.dependent.fill(v.data());
  double off_u = 0, off_v = 0, speed = 0;
  for (int64_t k = 0; k < u.size(); ++k) {
    off_u = std::max(off_u, std::abs(u.data()[k] - state.u.data()[k]));
    off_v = std::max(off_v, std::abs(v.data()[k] - state.v.data()[k]));
    speed = std::max(speed, std::abs(v.data()[k]));
  }
  EXPECT_LT(off_u, 1e-15);
  EXPECT_LT(off_v, 1e-12 * speed);
  return state;
}

TEST(HeldFem, StepsAsTheNetworkDoes) {
  for (const TimeScheme scheme :
       {TimeScheme::kEuler, TimeScheme::kBdf2, TimeScheme::kSdirk2, TimeScheme::kAuto}) {
    Scene scene = held_bar(0.7, 1.0 / 60);
    scene.scheme = scheme;
    scene.materials[0] = solid(2e5, 0.3);
    finish_scene(scene);
    // the network's steps
    const double end = 6 * scene.dt;
    SolverOptions options;
    options.mode = SolverMode::kNewton;
    options.tolerance = 1e-9;
    options.follows_time_error = false;
    Solver solver(scene, options);
    State state = initial_state(scene);
    while (state.time < end * (1 - 1e-9)) EXPECT_TRUE(solver.step(state).converged);
    // those of elements
    const FemScene body = as_fem(scene);
    const FemState own = swung(body, same(scheme), end, 1e-9);
    EXPECT_NEAR(own.time, state.time, 1e-12);
    double most = 0, off = 0;
    for (int64_t k = 0; k < own.u.size(); ++k) {
      const double u = state.x.data()[k] - body.mesh.rest.data()[k];
      most = std::max(most, std::abs(u));
      off = std::max(off, std::abs(u - own.u.data()[k]));
    }
    printf("steps of scheme %d against the network: %.2g of the largest displacement\n",
           int(scheme), off / most);
    EXPECT_LT(off, 1e-6 * most);
  }
}

TEST(HeldFem, SwingsAsItsMirrorImageDoes) {
  for (const fem::Scheme scheme : {fem::Scheme::kEuler, fem::Scheme::kBdf2, fem::Scheme::kNewmark,
                                   fem::Scheme::kSdirk2, fem::Scheme::kAuto}) {
    // the bar, and seen in a mirror
    Array<double> u[2];
    for (const bool mirror : {false, true}) {
      Scene scene = held_scene(
          box_surface({0, 0, 0}, {1, 0.2, 0.2}),
          {half_space_border(true, 0.01), half_space_border(false, 0.99)}, kBarEdge,
          {mirror ? 0.99 + 0.7 * kBarEdge : 0.01 - 0.7 * kBarEdge, 0.02, 0.02}, 1.0 / 60);
      scene.materials[0] = solid(2e5, 0.3);
      finish_scene(scene);
      const FemScene body = as_fem(scene);
      const FemState state = swung(body, scheme, 3 * scene.dt, 1e-8);
      std::vector<Vec3> points;
      for (const double x : {0.1, 0.25, 0.4, 0.7, 0.9, 0.99})
        points.push_back({mirror ? 1 - x : x, 0.07, 0.12});
      u[mirror] = at(scene, body, state.u, points);
    }
    // the same motion
    double most = 0, off = 0;
    for (int p = 0; p < 6; ++p)
      for (int d = 0; d < 3; ++d) {
        most = std::max(most, std::abs(u[0](p, d)));
        off = std::max(off, std::abs(u[0](p, d) - (d == 0 ? -1 : 1) * u[1](p, d)));
      }
    EXPECT_GT(most, 1e-3);
    EXPECT_LT(off, 1e-6 * most) << int(scheme);
    for (int d = 0; d < 3; ++d) EXPECT_LT(std::abs(u[0](5, d)), 1e-12);  // the held face
  }
}

TEST(HeldFem, TakesAboutTheIterationsOfAGridThatFits) {
  int64_t fit = 0;
  for (const double offset : {0.0, 1e-4, 0.3, 0.7, 0.95}) {
    const Scene scene = held_bar(offset, 100, 1.01);
    FemScene body = as_fem(scene);
    fem::ImplicitFem solver(body, {.tolerance = 1e-6, .linear = {.max_entries = 0}});
    FemState state = fem::rest_state(body);
    const fem::FemStepReport report = solver.step(state);
    EXPECT_TRUE(report.converged);
    if (offset == 0) fit = report.inner;
    printf("offset %.4f: %d iterations of PCG in %d Newton steps\n", offset, report.inner,
           report.outer);
    EXPECT_LT(double(report.inner), 1.3 * double(fit));
  }
}

/// Moves borders: c_i of dependent nodes so that a rigid motion of the body meets them.
void carry_borders(FemScene& body, const std::function<Vec3(const double* X, double time)>& rigid) {
  body.dependent_motion = [&body, rigid](double time, Out<double> offset) {
    for (int64_t i = 0; i < offset.rows; ++i) {
      const Vec3 own = rigid(body.mesh.rest.row(body.dependent.node(i)), time);
      std::copy(own.begin(), own.end(), offset.row(i));
      for (int64_t k = 0; k < body.dependent.parents(i).rows; ++k) {
        const Vec3 of = rigid(body.mesh.rest.row(body.dependent.parents(i)(k)), time);
        for (int d = 0; d < 3; ++d) offset(i, d) -= body.dependent.weights(i)(k) * of[size_t(d)];
      }
    }
  };
}

TEST(HeldFem, GoesWithBordersThatMove) {
  // at a constant velocity the body moves as one with them, whatever the scheme
  const Vec3 velocity = {0.3, -0.2, 0.1};
  for (const fem::Scheme scheme : {fem::Scheme::kEuler, fem::Scheme::kBdf2, fem::Scheme::kNewmark,
                                   fem::Scheme::kSdirk2, fem::Scheme::kAuto}) {
    Scene scene = held_bar(0.7, 1.0 / 60);
    scene.gravity = {};
    FemScene body = as_fem(scene);
    body.scheme = scheme;
    carry_borders(body,
                  [&](const double*, double time) { return elastogen::scaled(velocity, time); });
    FemState state = fem::rest_state(body);
    for (int64_t k = 0; k < state.v.size(); ++k) state.v.data()[k] = velocity[size_t(k % 3)];
    std::optional<fem::ImplicitFem> steps;
    std::optional<fem::StageFem> stages;
    if (scheme == fem::Scheme::kSdirk2 || scheme == fem::Scheme::kAuto)
      stages.emplace(body);
    else
      steps.emplace(body);
    for (int step = 0; step < 4; ++step) {
      const fem::FemStepReport report = stages ? stages->step(state) : steps->step(state);
      EXPECT_TRUE(report.converged) << report.residual;
    }
    for (int64_t k = 0; k < state.u.size(); ++k) {
      EXPECT_NEAR(state.u.data()[k], velocity[size_t(k % 3)] * state.time, 1e-10) << int(scheme);
      EXPECT_NEAR(state.v.data()[k], velocity[size_t(k % 3)], 1e-8) << int(scheme);
    }
  }
}

TEST(HeldFem, FrequenciesDoNotDependOnTheOffset) {
  double least = 1e300, most = 0;
  for (const double offset : {0.0, 0.3, 0.7, 0.97}) {
    const fem::Modes modes = vibration_modes(as_fem(held_bar(offset)), 1);
    least = std::min(least, modes.frequency[0]);
    most = std::max(most, modes.frequency[0]);
  }
  printf("lowest frequency %.4f to %.4f Hz\n", least, most);
  EXPECT_LT(most, 1.01 * least);
}

TEST(HeldFem, OfMetalYieldAlikeOnAnyGrid) {
  double least = 1e300, most = 0;
  for (const double offset : {0.0, 0.4, 0.8}) {
    const Scene scene = held_bar(offset, 100, 1.01, 0);
    FemScene body = as_fem(scene, Element::kHexBbar);
    body.yields = {MetalYield{.stress = 1.2e4, .hardening = 1e7}};
    const fem::StaticResult result = solve_static(body, {.tolerance = 1e-8});
    EXPECT_TRUE(result.converged);
    EXPECT_GT(result.energy.plastic, 0);
    double weight = 0, reaction = 0;
    for (int64_t n = 0; n < scene.mass.rows(); ++n) {
      weight += 9.81 * scene.mass(n);
      reaction += result.reaction(n, 1);
    }
    EXPECT_NEAR(reaction, weight, 1e-6 * weight);
    const double sag = -at(scene, body, result.u, {{0.51, 0.1, 0.1}})(0, 1);
    printf("metal, offset %.1f: sag %.5g m, flow %.3g J\n", offset, sag, result.energy.plastic);
    least = std::min(least, sag);
    most = std::max(most, sag);
  }
  // flow begins where points lie nearest to the held faces, at different distances
  EXPECT_LT(most, 1.05 * least);
}

TEST(HeldFem, OfGrainsStepOnTheirTrueForces) {
  // sand has no potential: roots of forces, with Jacobians that are not symmetric
  const Scene scene = held_bar(0.4, 1.0 / 240, 1.01, 0);
  FemScene body = as_fem(scene, Element::kHex);
  body.materials[0].young = 3e5;
  body.yields = {SandYield{.cohesion = 1e-3}};
  fem::ImplicitFem solver(body, {.tolerance = 1e-8, .as_positions = true});
  FemState state = fem::rest_state(body);
  for (int step = 0; step < 3; ++step) {
    const fem::FemStepReport report = step_in_parts(solver, state);
    EXPECT_TRUE(report.converged) << report.residual;
    EXPECT_TRUE(report.yields);
  }
  Array<double> followed = state.u;
  body.dependent.fill(followed.data());
  for (int64_t k = 0; k < followed.size(); ++k)
    EXPECT_NEAR(followed.data()[k], state.u.data()[k], 1e-15);
  EXPECT_LT(at(scene, body, state.u, {{0.51, 0.1, 0.1}})(0, 1), -1e-4);
}

}  // namespace
}  // namespace elastogen::test
