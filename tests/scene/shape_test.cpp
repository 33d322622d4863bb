// SPDX-License-Identifier: Apache-2.0
// Bodies without a file: their meshes, their particles, and what is refused.
#include "scene/shape.hpp"

#include "scene/particle_setup.hpp"
#include "scene/stepper.hpp"
#include "tests/io/test_files.hpp"

#include <cmath>
#include <numbers>

namespace elastogen::test {
namespace {

/// Volume that a closed surface bounds [m^3].
double volume_of(const Surface& s) {
  double volume = 0;
  for (int64_t t = 0; t < s.triangles.rows(); ++t) {
    Vec3 x[3];
    for (int k = 0; k < 3; ++k) std::copy_n(s.vertices.row(s.triangles(t, k)), 3, x[k].begin());
    volume += (x[0][0] * (x[1][1] * x[2][2] - x[1][2] * x[2][1]) +
               x[0][1] * (x[1][2] * x[2][0] - x[1][0] * x[2][2]) +
               x[0][2] * (x[1][0] * x[2][1] - x[1][1] * x[2][0])) /
              6;
  }
  return volume;
}

TEST(Shape, MeshesAreClosedAndHaveTheirVolume) {
  const Surface box = pose_surface(shape_asset(parse_shape("box(1,2,3, 200cm,3,5)")));
  EXPECT_EQ(box.vertices.rows(), 8);
  EXPECT_NEAR(volume_of(box), 2, 1e-12);
  const Surface ball = pose_surface(shape_asset(parse_shape("sphere(1,-2,3, 50 cm)")));
  const double exact = 4.0 / 3 * std::numbers::pi * 0.125;
  EXPECT_NEAR(volume_of(ball), exact, 2e-3 * exact);  // the vertices lie on the sphere
  EXPECT_LT(volume_of(ball), exact);
  EXPECT_EQ(ball.vertices.rows() - ball.triangles.rows() / 2, 2);  // Euler's characteristic
}

TEST(Shape, WhatCannotBeReadIsRefusedWithItsText) {
  for (const auto& [text, word] : {std::pair("cone(1,2,3, 4)", "none of the known"),
                                   {"box(0,0,0, 1,1)", "6 numbers"},
                                   {"sphere(0,0,0)", "4 numbers"},
                                   {"sphere(0,0,0, 0)", "radius"},
                                   {"box(0,1,0, 1,0,1)", "along y"},
                                   {"disk(0,0,1, 1)", "z = 0"},
                                   {"rectangle(0,0,0, 1,1,1)", "z = 0"},
                                   {"box(0,0,0, 1,1,1) friction 1", "bracket"},
                                   {"box(0,0,0, 1,1,1kg)", "kg"},
                                   {"box 0,0,0, 1,1,1", "bracket"}}) {
    const std::string said = error_of([&, shown = text] { parse_shape(shown); }, ErrorKind::kUsage);
    expect_says(said, word);
    expect_says(said, text);
  }
}

/// A column of sand in the plane on a floor.
RunDescription column() {
  RunDescription run;
  run.shape = parse_shape("rectangle(-0.05,0,0, 0.05,0.2,0)");
  run.h = 0.01;
  run.yield = SandYield{};
  run.material = {"sand", Law::kHencky, 1e6, 0.3, 1000};
  run.floor.emplace();
  run.friction = kSticks;
  run.particles.jitter = 0;
  run.particles.dt = 1e-3;
  run.fps = 50;
  return run;
}

TEST(Shape, ThePlaneIsFilledWithTheMassOfAMetre) {
  const RunDescription run = column();
  const auto setup = set_up(shape_asset(*run.shape), run);
  const mpm::Particles& p = setup.particles->particles;
  ASSERT_EQ(p.count(), 4 * 10 * 20);
  double mass = 0;
  for (int64_t k = 0; k < p.count(); ++k) {
    mass += p.mass(k);
    // the middles of quarters of cells, in z = 0
    EXPECT_NEAR(std::abs(std::remainder(p.x(k, 0), 0.005)), 0.0025, 1e-12);
    EXPECT_NEAR(std::abs(std::remainder(p.x(k, 1), 0.005)), 0.0025, 1e-12);
    EXPECT_EQ(p.x(k, 2), 0);
  }
  EXPECT_NEAR(mass, 1000 * 0.1 * 0.2, 1e-10);
  EXPECT_EQ(setup.substeps, 20);
}

/// Where a column is after some steps, each of which must converge.
CloudReport fallen(const RunDescription& run, int steps, State& state) {
  const auto setup = set_up(shape_asset(*run.shape), run);
  std::vector<std::string> notes;
  const std::unique_ptr<Stepper> stepper = make_stepper(setup, run, {}, notes);
  stepper->begin(run.motion);
  for (int n = 0; n < steps; ++n) EXPECT_TRUE(stepper->advance().converged) << "step " << n;
  state = stepper->state();
  return stepper->cloud().value();
}

TEST(Shape, ImplicitAndExplicitStepsBetweenTheSameTransfersAgree) {
  RunDescription run = column();
  State implicit, sub;
  const CloudReport a = fallen(run, 60, implicit);
  EXPECT_EQ(run.particles.dt, 1e-3);
  run.particles.integrator = Integrator::kExplicit;
  run.particles.substeps = 40;
  run.substeps = 20;
  const CloudReport b = fallen(run, 60, sub);
  EXPECT_NEAR(implicit.time, sub.time, 1e-12);
  const double moved = 0.5 * 9.81 * sub.time * sub.time;
  double apart = 0;
  for (int64_t k = 0; k < implicit.x.rows(); ++k)
    for (int c = 0; c < 3; ++c) apart = std::max(apart, std::abs(implicit.x(k, c) - sub.x(k, c)));

  EXPECT_LT(apart, 0.1 * moved);
  for (const CloudReport& cloud : {a, b}) {
    EXPECT_EQ(cloud.lower[2], 0);
    EXPECT_NEAR(cloud.upper[0], -cloud.lower[0], 1e-9);  // to both sides alike
    EXPECT_GT(cloud.upper[0], 0.0475);
    EXPECT_LT(cloud.upper[1], 0.1975);
  }
}

TEST(Shape, WhatThePlaneCannotDoIsRefused) {
  const auto refused = [](const std::function<void(RunDescription&)>& change) {
    RunDescription run = column();
    change(run);
    return error_of([&] { set_up(shape_asset(*run.shape), run); }, ErrorKind::kUsage);
  };
  expect_says(refused([](RunDescription& run) { run.yield = {}; }), "a material that yields");
  expect_says(refused([](RunDescription& run) { run.gravity = Vec3{0, 0, -1}; }), "z = 0");
  expect_says(refused([](RunDescription& run) { run.motion.spin[0] = 1; }), "z = 0");
  expect_says(refused([](RunDescription& run) {
                run.colliders = {parse_obstacle("plane(0,0,-1, 0,0,1) name lid")};
              }),
              "'lid'");
  expect_says(refused([](RunDescription& run) {
                run.colliders = {parse_obstacle("sphere(0,0.1,0, 0.05) name ball")};
              }),
              "'ball'");
  expect_says(refused([](RunDescription& run) { run.pins = {parse_pin("all")}; }), "--pin");
}

TEST(Shape, OnlyParticlesStick) {
  RunDescription run;
  run.shape = parse_shape("box(0,0,0, 1,1,1)");
  run.voxels = 2;
  run.floor.emplace();
  run.friction = kSticks;
  expect_says(error_of([&] { set_up(shape_asset(*run.shape), run); }, ErrorKind::kUsage),
              "only particles stick");
}

}  // namespace
}  // namespace elastogen::test
