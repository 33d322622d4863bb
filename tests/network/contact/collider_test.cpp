// SPDX-License-Identifier: Apache-2.0
// Contact with spheres, boxes and colliders that move.
#include "network/contact/contact.hpp"
#include "network/solver.hpp"
#include "tests/network/contact/contact_scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

using Shape = Collider::Shape;

double total_mass(const Scene& scene) {
  double sum = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) sum += scene.mass(n);
  return sum;
}

double mean_velocity(const Scene& scene, const State& state, int axis) {
  double sum = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) sum += scene.mass(n) * state.v(n, axis);
  return sum / total_mass(scene);
}

/// Smallest distance of a surface point from a collider at the end of a run.
double least_distance(const Scene& scene, const State& state, const Collider& c) {
  double least = 1e300;
  const SurfacePoints& s = scene.surface;
  for (int64_t p = 0; p < s.voxel.rows(); ++p) {
    Vec3 x = {};
    for (int k = 0; k < 8; ++k)
      for (int i = 0; i < 3; ++i)
        x[size_t(i)] += s.weights(p, k) * state.x(scene.grid.corners(s.voxel(p), k), i);
    least = std::min(least, proximity(c, offset_at(c, state.time), x).distance);
  }
  return least;
}

TEST(Colliders, GradientIsTheDerivativeOfTheEnergyForEveryShape) {
  // points in the layer of one collider at a time, of the boxes at a face and at edges; the ball
  // moves, so that slip is relative
  const double h = 0.05, layer = h / 4;
  std::vector<Collider> colliders = {
      ball({0.1, -0.3 + 0.4 * layer, 0.1}, 0.3), block({-0.1 + 0.5 * layer, 0.1, 0.1}, {0.1, 1, 1}),
      block({0.3, 0.3, 0.3}, {0.1325, 0.1325, 0.1325}), half_space({0, -0.6, -0.8}, -0.25875, 0.7)};
  colliders[0].path = {{0, {}}, {1, {0.06, 0, 0.03}}};
  for (size_t k = 0; k < colliders.size(); ++k) {
    const Scene scene = box_scene(4, 4, 4, h, {0, 0, 0}, solid(1e5, 0.3), {colliders[k]});
    Contact contact(scene);
    std::vector<double> u = random_field(scene, 0.02 * h, 3);
    contact.begin_step(u.data());
    const std::vector<double> away = random_field(scene, 0.02 * h, 4);
    const std::vector<double> p = random_field(scene, 1, 5);
    for (size_t i = 0; i < u.size(); ++i) u[i] += away[i];
    std::vector<double> g(u.size()), plus = u, minus = u;
    const double energy = contact.evaluate(u.data(), g.data());
    ASSERT_TRUE(std::isfinite(energy) && energy > 0) << "collider " << k;
    const double e = 1e-8;
    for (size_t i = 0; i < u.size(); ++i) plus[i] += e * p[i], minus[i] -= e * p[i];
    const double slope = (contact.evaluate<double>(plus.data(), nullptr) -
                          contact.evaluate<double>(minus.data(), nullptr)) /
                         (2 * e);
    EXPECT_NEAR(slope, dot(g, p), 2e-6 * norm(g) * norm(p)) << "collider " << k;
  }
}

TEST(Colliders, ABallRestsOnSphereAndBox) {
  const double R = 0.1, h = 0.04, weight_share = 2e-3;
  for (const bool on_box : {false, true}) {
    Scene scene = scene_on(ball_grid(R, h), solid(2e5, 0.3));
    scene.surface = face_points(scene.grid);
    // the voxel faces of a ball: their lowest point
    double lowest = 1e300;
    for (int64_t p = 0; p < scene.surface.position.rows(); ++p)
      lowest = std::min(lowest, scene.surface.position(p, 1));
    scene.colliders = {on_box ? block({0, lowest - 0.3, 0}, {0.3, 0.3, 0.3})
                              : ball({0, lowest - 3, 0}, 3)};
    scene.gravity = {0, -9.81, 0};
    finish_scene(scene);
    Solver solver(scene, {.tolerance = 1e-5});
    State state = initial_state(scene);
    for (int k = 0; k < 90; ++k) {
      const StepReport report = solver.step(state);
      ASSERT_TRUE(report.converged) << "step " << k << " residual " << report.residual;
      EXPECT_LT(report.deepest_overlap, 0.25);
    }
    Contact contact(scene);
    const std::vector<double> u = displacement(scene, state);
    std::vector<double> g(u.size());
    contact.begin_step(u.data());
    contact.evaluate(u.data(), g.data());
    double push = 0;
    for (size_t k = 1; k < g.size(); k += 3) push -= g[k];
    EXPECT_NEAR(push / (9.81 * total_mass(scene)), 1, weight_share) << (on_box ? "box" : "ball");
    EXPECT_LT(std::abs(mean_velocity(scene, state, 1)), 1e-3);
  }
}

TEST(Colliders, AMovingPlanePressesABlockAsUniaxialCompressionSays) {
  // frictionless between two planes, free at the sides, poisson 0: sigma = P(lambda) of the law,
  // neo-hookean with lambda = 0: P = mu (l - 1/l), mu = E/2
  const double h = 0.05, young = 1e5, travel = 0.02;
  const int n = 4;
  Collider press = half_space({0, -1, 0}, -n * h, 0);
  press.name = "press";
  press.path = {{0, {}}, {0.5, {0, -travel, 0}}};
  const Scene scene =
      box_scene(n, n, n, h, {0, 0, 0}, solid(young, 0), {half_space({0, 1, 0}, 0, 0), press}, 0);
  Solver solver(scene, {.tolerance = 1e-4});
  State state = initial_state(scene);
  StepReport report;
  for (int k = 0; k < 90; ++k) {
    report = solver.step(state);
    ASSERT_TRUE(report.converged) << "step " << k << " residual " << report.residual;
  }
  // force on both planes and the height that the block is left with
  Contact contact(scene);
  const std::vector<double> u = displacement(scene, state);
  std::vector<double> g(u.size());
  contact.begin_step(u.data(), state.time);
  contact.evaluate(u.data(), g.data());
  double load = 0, total = 0, bottom = 0, top = 0;
  for (int64_t m = 0; m < scene.grid.node_count(); ++m) {
    const double f = g[3 * size_t(m) + 1];
    total += f;
    if (f > 0) load += f;
    if (scene.grid.node_coord(m, 1) == 0) bottom += state.x(m, 1) / ((n + 1) * (n + 1));
    if (scene.grid.node_coord(m, 1) == n) top += state.x(m, 1) / ((n + 1) * (n + 1));
  }
  const double stretch = (top - bottom) / (n * h), area = n * n * h * h;
  const double expected = young / 2 * (1 / stretch - stretch) * area;
  printf("press: stretch %.5f, load %.4f N, law %.4f N, overlap %.3f h\n", stretch, load, expected,
         report.deepest_overlap);
  EXPECT_NEAR(load, expected, 0.02 * expected);
  EXPECT_LT(std::abs(total), 1e-3 * load);  // both planes carry the same
  // the block is as high as the gap and its overlaps with the layers on both sides
  EXPECT_NEAR(top - bottom, n * h - travel + 2 * report.deepest_overlap * h, 1e-3 * n * h);
  EXPECT_LT(stretch, 0.95);
}

TEST(Colliders, ABodyMovesWithAPlaneThatRises) {
  const double speed = 0.4, h = 0.05;
  Collider lift = half_space({0, 1, 0}, 0, 0.5);
  lift.path = {{0, {}}, {10, {0, 10 * speed, 0}}};
  const Scene scene = box_scene(4, 4, 4, h, {0, 0, 0}, solid(1e5, 0.3), {lift});
  Solver solver(scene, {.tolerance = 1e-5});
  State state = initial_state(scene);
  for (int k = 0; k < 120; ++k) ASSERT_TRUE(solver.step(state).converged) << "step " << k;
  EXPECT_NEAR(mean_velocity(scene, state, 1), speed, 1e-3 * speed);
  EXPECT_NEAR(least_distance(scene, state, lift), 0, 0.25 * h);
}

TEST(Colliders, AFastPlaneTakesTheBodyAlong) {
  // 40 voxels a step, many times the layer: the start of each step has to be carried
  const double h = 0.05, speed = 40 * h * 60;
  Collider lift = half_space({0, 1, 0}, 0, 0.5);
  lift.path = {{0, {}}, {10, {0, 10 * speed, 0}}};
  const Scene scene = box_scene(3, 3, 3, h, {0, 0, 0}, solid(1e6, 0.3), {lift}, 0);
  Solver solver(scene, {});
  State state = initial_state(scene);
  for (int k = 0; k < 5; ++k) {
    const StepReport report = solver.step(state);
    ASSERT_TRUE(report.finite) << report.refusal;
    EXPECT_GT(least_distance(scene, state, lift), -h / 4);
  }
  EXPECT_GT(mean_velocity(scene, state, 1), 0.9 * speed);
}

TEST(Colliders, TwoPlanesThatCloseSqueezeASheetBetweenThem) {
  // half of the sheet's thickness in one step: the nodes in between are squeezed evenly
  const double h = 0.05;
  Collider press = half_space({0, -1, 0}, -h, 0);
  press.path = {{0, {}}, {1.0 / 60, {0, -h / 2, 0}}};
  const Scene scene =
      box_scene(4, 1, 4, h, {0, 0, 0}, solid(1e5, 0.3), {half_space({0, 1, 0}, 0, 0), press}, 0);
  Solver solver(scene, {});
  State state = initial_state(scene);
  for (int k = 0; k < 5; ++k) {
    const StepReport report = solver.step(state);
    ASSERT_TRUE(report.finite) << report.refusal;
    EXPECT_LT(report.deepest_overlap, 0.25);
  }
}

TEST(Colliders, ACarriedStartKeepsTheDistanceOfEveryPoint) {
  const double h = 0.05;
  Collider lift = half_space({0, 1, 0}, 0, 0.5), obstacle = half_space({1, 0, 0}, 0, 0.5);
  lift.path = {{0, {}}, {1.0 / 60, {0, 0.3 * h, 0}}};
  const Scene scene = box_scene(3, 6, 3, h, {0, 0, 0}, solid(1e6, 0.3), {obstacle, lift}, 0);
  Contact contact(scene);
  std::vector<double> u(3 * size_t(scene.grid.node_count()));
  contact.begin_step(u.data());
  EXPECT_EQ(contact.obstacle(u.data())->name, "floor");
  contact.carry(u.data());
  EXPECT_EQ(contact.obstacle(u.data()), nullptr);
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    // the lowest voxels move with it, those beyond its reach stay; the plane beside hinders nothing
    const int layer = scene.grid.node_coord(n, 1);
    const double moved = u[3 * size_t(n) + 1];
    EXPECT_TRUE(layer > 1 || std::abs(moved - 0.3 * h) < 1e-15) << layer << ' ' << moved;
    EXPECT_TRUE(layer < 4 || moved == 0) << layer << ' ' << moved;
    EXPECT_EQ(u[3 * size_t(n)], 0);
  }
}

TEST(Colliders, APinnedPartInTheWayIsRefusedByName) {
  const double h = 0.05;
  Collider press = half_space({0, 1, 0}, 0, 0.5);
  press.name = "press";
  press.path = {{1.0 / 60, {}}, {2.0 / 60, {0, h, 0}}};
  Scene scene = scene_on(make_box(3, 3, 3, h), solid(1e6, 0.3));
  scene.surface = face_points(scene.grid);
  scene.colliders = {press};
  pin_below(scene, 1, h / 2);
  finish_scene(scene);
  Solver solver(scene, {});
  State state = initial_state(scene);
  ASSERT_TRUE(solver.step(state).finite);
  const Array<double> before = state.x;
  const StepReport report = solver.step(state);
  EXPECT_FALSE(report.finite);
  EXPECT_NE(report.refusal.find("'press'"), std::string::npos) << report.refusal;
  EXPECT_EQ(state.x, before);
}

TEST(Colliders, AConveyorDragsABodyToItsSpeed) {
  // friction mu g until the speeds are the same
  const double mu = 0.3, g = 9.81, speed = 1.5, h = 0.1;
  Collider belt = half_space({0, 1, 0}, 0, mu);
  // at rest while the block settles
  belt.path = {{1, {}}, {11, {10 * speed, 0, 0}}};
  const Scene scene = box_scene(4, 2, 4, h, {0, 0, 0}, solid(1e6, 0.2), {belt});
  Solver solver(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-5});
  State state = initial_state(scene);
  std::vector<double> v;
  for (int k = 0; k < 120; ++k) {
    ASSERT_TRUE(solver.step(state).converged) << "step " << k;
    v.push_back(mean_velocity(scene, state, 0));
  }
  EXPECT_NEAR(v[58], 0, 1e-3);
  // a third of a second of sliding, after the first jolt
  const double acceleration = (v[84] - v[66]) * 60 / 18;
  printf("conveyor: acceleration %.4f m/s^2, Coulomb %.4f; speed %.4f of %.1f m/s\n", acceleration,
         mu * g, v.back(), speed);
  EXPECT_NEAR(acceleration, mu * g, 0.02 * mu * g);
  EXPECT_NEAR(v.back(), speed, 0.02 * speed);
}

TEST(Colliders, NothingTunnelsAtTenKilometresASecond) {
  const double h = 0.05;
  const std::vector<Collider> targets = {half_space({0, 1, 0}, 0, 0.3), ball({0.1, -0.5, 0.1}, 0.5),
                                         block({0.1, -0.5, 0.1}, {100, 0.5, 100}),
                                         block({0.1, -0.001, 0.1}, {100, 0.001, 100})};
  for (const Collider& target : targets)
    for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
      const Scene scene = box_scene(4, 4, 4, h, {0, h, 0}, solid(1e6, 0.3), {target});
      Solver solver(scene, {.mode = mode, .max_outer = 40});
      State state = initial_state(scene, {.velocity = {0, -1e4, 0}});
      const Collider core = core_of(target, h / 4);
      for (int k = 0; k < 4; ++k) {
        const StepReport report = solver.step(state);
        EXPECT_TRUE(report.finite) << target.name << ' ' << report.refusal;
        EXPECT_GT(least_distance(scene, state, core), 0) << target.name;
        // the thin plate has two sides
        const Collider above = half_space({0, 1, 0}, 0, 0);
        EXPECT_TRUE(target.shape == Shape::kSphere || least_distance(scene, state, above) > -h / 4)
            << target.name << ": a point is on the far side";
      }
    }
}

}  // namespace
}  // namespace elastogen::test
