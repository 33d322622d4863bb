// SPDX-License-Identifier: Apache-2.0
#include "network/contact/contact.hpp"

#include "core/error.hpp"
#include "network/solver.hpp"
#include "tests/network/contact/contact_scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

/// A free full box above the floor y = 0, with its surface points; finished.
Scene box_on_floor(int nx, int ny, int nz, double h, double gap, double friction,
                   const Material& material, const Vec3& gravity = {0, -9.81, 0}) {
  Scene scene = scene_on(make_box(nx, ny, nz, h, {0, gap, 0}), material);
  scene.surface = face_points(scene.grid);
  scene.colliders = {half_space({0, 1, 0}, 0, friction)};
  scene.gravity = gravity;
  finish_scene(scene);
  return scene;
}

TEST(Contact, ABodyThatStandsExactlyOnTheFloorFeelsNoForce) {
  const Scene scene = box_on_floor(4, 4, 4, 0.05, 0, 0.5, solid(1e5, 0.3));
  Contact contact(scene);
  const std::vector<double> u(3 * size_t(scene.grid.node_count()));
  std::vector<double> g(u.size());
  contact.begin_step(u.data());
  EXPECT_EQ(contact.evaluate(u.data(), g.data()), 0);
  EXPECT_EQ(norm(g), 0);
  EXPECT_EQ(contact.deepest_overlap(u.data()), 0);
}

TEST(Contact, ForceIsTheDerivativeOfTheBarrierTimesArea) {
  // pressed down by half the layer: each bottom point of area h^2 carries
  // kappa h^2 b'(1/2)/dhat with kappa = E dhat^2/h, b' = 2(1-s) ln s - (1-s)^2/s
  const double h = 0.05, young = 1e5, layer = h / 4;
  const Scene scene = box_on_floor(4, 3, 2, h, 0, 0, solid(young, 0.3));
  Contact contact(scene);
  std::vector<double> u(3 * size_t(scene.grid.node_count())), g(u.size());
  for (size_t k = 1; k < u.size(); k += 3) u[k] = -layer / 2;
  contact.begin_step(u.data());
  contact.evaluate(u.data(), g.data());
  double sum[3] = {};
  for (size_t k = 0; k < g.size(); ++k) sum[k % 3] += g[k];
  const double slope = 2 * 0.5 * std::log(0.5) - 0.25 / 0.5;
  EXPECT_NEAR(sum[1], 4 * 2 * h * h * young * layer * layer / h * slope / layer,
              1e-9 * std::abs(sum[1]));
  EXPECT_LT(sum[1], 0);  // the gradient: energy falls upwards
  EXPECT_EQ(sum[0], 0);
  EXPECT_NEAR(contact.deepest_overlap(u.data()), layer / 2, 1e-15);
}

TEST(Contact, EnergyIsInfiniteBehindTheWallAndStepsStopBeforeIt) {
  const Scene scene = box_on_floor(2, 2, 2, 0.05, 0.02, 0.5, solid(1e5, 0.3));
  Contact contact(scene);
  std::vector<double> u(3 * size_t(scene.grid.node_count())), p(u.size());
  for (size_t k = 1; k < p.size(); k += 3) p[k] = -1;
  // the floor is 0.02 + 0.0125 below: a step may go nine tenths of that distance
  EXPECT_NEAR(contact.longest_step(u.data(), p.data()), 0.9 * 0.0325, 1e-12);
  contact.begin_step(u.data());
  EXPECT_EQ(contact.evaluate<double>(p.data(), nullptr), std::numeric_limits<double>::infinity());
  for (double& value : p) value = -value;
  EXPECT_EQ(contact.longest_step(u.data(), p.data()), 1);
  // from 1 cm lower the floor is nearer, and standing still is no approach
  for (size_t k = 1; k < u.size(); k += 3) u[k] = -0.01, p[k] = -1.01;
  EXPECT_NEAR(contact.longest_step(u.data(), p.data()), 0.9 * 0.0225, 1e-12);
  EXPECT_EQ(contact.longest_step(u.data(), u.data()), 1);
}

TEST(Contact, AFloorNeedsSurfacePoints) {
  Scene scene = scene_on(make_box(2, 2, 2, 0.1), solid(1e5, 0.3));
  scene.colliders = {half_space({0, 1, 0}, 0, 0.5)};
  finish_scene(scene);
  EXPECT_THROW(Contact{scene}, Error);
}

TEST(Contact, AStandingBodySinksByLessThanTheLayerAndSettles) {
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton}) {
    const Scene scene = box_on_floor(4, 4, 4, 0.05, 0, 0.5, solid(1e5, 0.3));
    Solver solver(scene, {.mode = mode});
    State state = initial_state(scene);
    StepReport report;
    for (int k = 0; k < 60; ++k) {
      report = solver.step(state);
      EXPECT_TRUE(report.converged) << "step " << k << " residual " << report.residual;
      EXPECT_LT(report.deepest_overlap, 0.25);
    }
    EXPECT_GT(report.deepest_overlap, 0);
    double fastest = 0;
    for (int64_t k = 0; k < state.v.size(); ++k)
      fastest = std::max(fastest, std::abs(state.v.data()[k]));
    printf("standing box (%s): overlap %.3f h, fastest node %.1e m/s\n", solver_name(mode).data(),
           report.deepest_overlap, fastest);
    EXPECT_LT(fastest, 1e-3);
  }
}

TEST(Contact, TheFloorCarriesTheWeight) {
  const Scene scene = box_on_floor(4, 4, 4, 0.05, 0, 0.5, solid(1e5, 0.3));
  Solver solver(scene, {.tolerance = 1e-5});
  State state = initial_state(scene);
  for (int k = 0; k < 120; ++k) ASSERT_TRUE(solver.step(state).converged);
  Contact contact(scene);
  const std::vector<double> u = displacement(scene, state);
  std::vector<double> g(u.size());
  contact.begin_step(u.data());
  contact.evaluate(u.data(), g.data());
  double push = 0, weight = 0;
  for (size_t k = 1; k < g.size(); k += 3) push -= g[k];
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) weight += 9.81 * scene.mass(n);
  EXPECT_NEAR(push / weight, 1, 1e-3);
}

TEST(Contact, ADroppedBeamNeverPassesTheLayer) {
  for (const SolverMode mode : {SolverMode::kQuasi, SolverMode::kNewton, SolverMode::kAuto}) {
    const double h = 0.025;
    const Scene scene =
        box_on_floor(20, 5, 5, h, 2 * h, 0.3, solid(young_of_courant(6.7, h, 1.0 / 60), 0.4));
    Solver solver(scene, {.mode = mode});
    State state = initial_state(scene, {.velocity = {0.3, -1, 0}, .spin = {0, 0, 0.5}});
    printf("dropped beam (%s), outer/inner a step:", solver_name(mode).data());
    for (int k = 0; k < 15; ++k) {
      const StepReport report = solver.step(state);
      printf(" %d/%d", report.outer, report.inner);
      EXPECT_TRUE(report.converged)
          << solver_name(mode) << " step " << k << " residual " << report.residual;
      EXPECT_LT(report.deepest_overlap, 0.25);
    }
    printf("\n");
  }
}

TEST(Contact, AFastBodyDoesNotTunnel) {
  // a hundred voxels a step towards the floor
  const double h = 0.025;
  const Scene scene = box_on_floor(4, 4, 4, h, 0.5 * h, 0.3, solid(1e6, 0.3));
  Solver solver(scene, {});
  State state = initial_state(scene, {.velocity = {0, -100 * h * 60, 0}});
  for (int k = 0; k < 5; ++k) {
    const StepReport report = solver.step(state);
    EXPECT_TRUE(report.finite);
    EXPECT_LT(report.deepest_overlap, 0.25);
  }
}

/// A stiff block under gravity turned by atan(1/2): an inclined plane. Mean slip speed [m/s] after
/// each step, which starts from a settled block.
std::vector<double> slide(double friction, int steps, double& size) {
  const double g = 9.81, s = 1 / std::sqrt(5.0), h = 0.1;
  const Scene scene =
      box_on_floor(3, 2, 2, h, 0, friction, solid(1e6, 0.2), {g * s, -2 * g * s, 0});
  size = 3 * h;
  Solver solver(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-6});
  State state = initial_state(scene);
  std::vector<double> speed;
  double mass = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) mass += scene.mass(n);
  for (int k = 0; k < steps; ++k) {
    EXPECT_TRUE(solver.step(state).converged) << "step " << k;
    double sum = 0;
    for (int64_t n = 0; n < scene.grid.node_count(); ++n) sum += scene.mass(n) * state.v(n, 0);
    speed.push_back(sum / mass);
  }
  return speed;
}

TEST(Contact, AnImpactBeyondWhatConvergesBringsNoEnergy) {
  // drafts end no higher than they began, and the body is found again
  Scene scene = box_on_floor(4, 4, 4, 0.05, 0.1, 0.5, solid(1e6, 0.3));
  scene.dt = 1.0 / 240;
  finish_scene(scene);
  Solver solver(scene, {});
  State state = initial_state(scene, {.velocity = {0, -3e4, 0}});
  const double start = 0.5 * (1000 * 0.2 * 0.2 * 0.2) * 9e8;
  int drafts = 0;
  StepReport report;
  for (int k = 0; k < 12; ++k) {
    report = solver.step(state);
    ASSERT_TRUE(report.finite) << k;
    drafts += !report.converged;
    ASSERT_LT(report.energy.kinetic + report.energy.elastic + report.energy.hourglass, start) << k;
  }
  EXPECT_GT(drafts, 0);  // else this asks for nothing
  EXPECT_TRUE(report.converged);
}

TEST(Contact, ABlockSlidesWhereFrictionIsTooSmall) {
  double size;
  const std::vector<double> speed = slide(0.49, 120, size);
  const double acceleration = (speed[119] - speed[59]) * 60 / 60;
  printf("mu 0.49: acceleration %.5f m/s^2, Coulomb 0.08774\n", acceleration);
  EXPECT_NEAR(acceleration, 0.08774, 0.02 * 0.08774);
}

TEST(Contact, ABlockHoldsWhereFrictionSufficesAndCreepsBelowTheSmoothingSpeed) {
  // creep at which 2 r - r^2 = 0.5/0.51, r = v/v_e, v_e = 1e-3 sqrt(g size)
  double size;
  const std::vector<double> speed = slide(0.51, 90, size);
  const double limit = 1e-3 * std::sqrt(9.81 * size), r = 1 - std::sqrt(1 - 0.5 / 0.51);
  printf("mu 0.51: creep %.3e m/s, predicted %.3e\n", speed.back(), r * limit);
  EXPECT_LT(speed.back(), limit);
  EXPECT_NEAR(speed.back(), r * limit, 0.05 * limit);
}

TEST(Contact, ActsOnAPieceWithTheSumOfItsNodalForces) {
  const double h = 0.05, layer = h / 4;
  const Scene scene =
      box_scene(4, 3, 5, h, {0, 0, 0}, solid(1e5, 0.3), {half_space({0, 1, 0}, 0.4 * layer, 0.5)});
  Contact contact(scene);
  std::vector<double> u = random_field(scene, 0.02 * h, 3), v = random_field(scene, 1, 5);
  contact.begin_step(u.data());
  const std::vector<double> away = random_field(scene, 0.02 * h, 4);
  for (size_t k = 0; k < u.size(); ++k) u[k] += away[k];
  std::vector<double> g(u.size());
  const double energy = contact.evaluate(u.data(), g.data());
  const Vec3 about = {0.3, -0.2, 0.1};
  const ActionSums sums = contact.act(u.data(), v.data(), v.data(), {about});
  ASSERT_EQ(sums.pieces.size(), 1u);

  Vec3 force = {}, torque = {};
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    Vec3 f = {}, x = {};
    for (size_t d = 0; d < 3; ++d) {
      f[d] = -g[3 * size_t(n) + d];
      x[d] = scene.grid.rest(n, int64_t(d)) + u[3 * size_t(n) + d];
    }
    force = plus(force, f);
    torque = plus(torque, cross(minus(x, about), f));
  }
  const ContactAction& action = sums.pieces[0];
  EXPECT_LT(safe_norm(minus(action.force, force)), 1e-12 * safe_norm(force));
  EXPECT_LT(safe_norm(minus(action.torque, torque)), 1e-12 * safe_norm(force));
  // the floor's normal is y: its forces are all along it, and friction has energy of its own
  EXPECT_NEAR(action.normal, force[1], 1e-12 * action.normal);
  EXPECT_GT(action.normal, 0);
  EXPECT_LT(sums.energy, energy);
  // a body that sinks at 2 m/s gives the floor that power
  for (size_t k = 0; k < v.size(); ++k) v[k] = k % 3 == 1 ? -2 : 0;
  EXPECT_NEAR(contact.act(u.data(), v.data(), v.data(), {about}).pieces[0].power,
              -2 * action.normal, 1e-12 * action.normal);
}

TEST(Contact, RelaxedFrictionGoesAShareOfTheWay) {
  // a body that slides far, so that friction is mu N, and sinks in between
  const double h = 0.05, layer = h / 4, dt = 0.01, share = 0.3;
  const Scene scene =
      box_scene(4, 3, 5, h, {0, 0, 0}, solid(1e5, 0.3), {half_space({0, 1, 0}, 0.6 * layer, 0.5)});
  Contact contact(scene);
  std::vector<double> u(size_t(scene.grid.rest.size()));
  contact.begin_stage(u.data(), 0, dt, u.data(), 0);
  for (size_t k = 0; k < u.size(); ++k) u[k] = k % 3 == 0 ? 10 * h : k % 3 == 1 ? -0.2 * layer : 0;
  const auto pull = [&] {  // of the floor along the slip [N]
    std::vector<double> g(u.size());
    contact.evaluate(u.data(), g.data());
    double sum = 0;
    for (size_t k = 0; k < g.size(); k += 3) sum += g[k];
    return sum;
  };
  const double first = pull();
  ASSERT_TRUE(contact.renew_lag(u.data()));
  const double end = pull();
  ASSERT_GT(end, 1.2 * first);
  contact.relax_lag(share);
  EXPECT_NEAR(pull(), (1 - share) * first + share * end, 1e-9 * end);
  // one that does not touch any more has a share of its friction left
  contact.renew_lag(u.data());
  const std::vector<double> there = u;
  for (size_t k = 1; k < u.size(); k += 3) u[k] = layer;
  ASSERT_TRUE(contact.renew_lag(u.data()));
  u = there;
  EXPECT_EQ(pull(), 0);
  contact.relax_lag(share);
  EXPECT_NEAR(pull(), (1 - share) * end, 1e-9 * end);
}

TEST(Contact, RelaxedFrictionTakesANormalBetween) {
  const ContactLag last{2, {1, 0, 0}}, end{4, {0, 1, 0}};
  for (const double share : {0.25, 0.5}) {
    const ContactLag lag = relaxed_lag(last, end, share);
    EXPECT_NEAR(lag.limit, 2 + 2 * share, 1e-12);
    EXPECT_NEAR(safe_norm(lag.normal), 1, 1e-12);
    EXPECT_NEAR(lag.normal[1] / lag.normal[0], share / (1 - share), 1e-12);
  }
  // opposite normals have none between
  EXPECT_EQ(relaxed_lag(last, {2, {-1, 0, 0}}, 0.5).normal, (Vec3{-1, 0, 0}));
}

TEST(Contact, FloorsThatMoveAndSlidingHavePowers) {
  // all points slide at one velocity along a floor that rises and moves along, with full friction
  const double h = 0.05, layer = h / 4, dt = 0.01;
  Scene scene =
      box_scene(4, 3, 5, h, {0, 0, 0}, solid(1e5, 0.3), {half_space({0, 1, 0}, 0.4 * layer, 0.5)});
  scene.colliders[0].path = {{0, {}}, {1, {0.3, 0.2, 0}}};
  Contact contact(scene);
  std::vector<double> u(size_t(scene.grid.rest.size())), v(u.size());
  const Vec3 speed = {1, 0.2, -0.5};
  for (size_t k = 0; k < u.size(); ++k) v[k] = speed[k % 3];
  contact.begin_stage(u.data(), 0, dt, u.data(), 0);
  for (size_t k = 0; k < u.size(); ++k) u[k] = dt * v[k];
  ASSERT_TRUE(contact.renew_lag(u.data()));
  const ActionSums sums = contact.act(u.data(), v.data(), v.data(), {{}});
  const ContactAction& action = sums.pieces[0];
  const double slides = std::hypot(0.7, 0.5);
  EXPECT_NEAR(action.rubbed, 0.5 * action.normal * slides, 1e-9 * action.normal);
  EXPECT_NEAR(action.driven, 0.2 * action.normal + 0.3 * action.force[0], 1e-9 * action.normal);
  EXPECT_NEAR(action.force[0], -0.5 * action.normal * 0.7 / slides, 1e-9 * action.normal);
  // what bonds hold is (mu N)^2 / (2 k_t) of each point
  double held = 0;
  contact.keep_bonds(u.data());
  for (int64_t p = 0; p < contact.bonds().rows; ++p) {
    const double kt = contact.lengths().bond * contact.stiffness()[size_t(p)];
    for (int d = 0; d < 3; ++d) held += kt * std::pow(contact.bonds()(p, d), 2) / 2;
  }
  EXPECT_GT(held, 0);
  EXPECT_NEAR(sums.bonds, held, 1e-12 * held);
}

/// A block that lies in the layer of a floor, which its points are bonded to, and is pushed along x.
struct Bonded {
  static constexpr double kFriction = 0.5, kH = 0.05;
  Scene scene = box_scene(4, 3, 5, kH, {0, 0, 0}, solid(1e5, 0.3),
                          {half_space({0, 1, 0}, 0.1 * kH, kFriction)});
  Contact contact{scene};
  std::vector<double> u = std::vector<double>(3 * size_t(scene.grid.node_count()));
  std::vector<double> g = u;

  void begin(const std::vector<double>& from, double time) {
    u = from;
    contact.begin_stage(u.data(), time, 0.01, u.data(), time);
  }
  std::vector<double> pushed(double way) const {
    std::vector<double> moved = u;
    for (size_t k = 0; k < u.size(); k += 3) moved[k] += way;
    return moved;
  }
  double energy(const std::vector<double>& at) {
    std::fill(g.begin(), g.end(), 0.0);
    return contact.evaluate(at.data(), g.data());
  }
  /// The forces along x and against the floor.
  std::pair<double, double> pull(const std::vector<double>& at) {
    energy(at);
    std::pair<double, double> sums;
    for (size_t k = 0; k < g.size(); k += 3) sums.first += g[k], sums.second -= g[k + 1];
    return sums;
  }
};

TEST(Contact, BondsPullByTheDerivativeOfTheirEnergy) {
  Bonded b;
  b.begin(b.u, 0);
  const double normal = b.pull(b.u).second;
  ASSERT_GT(normal, 0);
  const double holds = 1e-7 * Bonded::kFriction * normal / b.pull(b.pushed(1e-7)).first;
  for (const double share : {0.6, 3.0}) {
    std::vector<double> at = b.pushed(share * holds);
    EXPECT_NEAR(b.pull(at).first, std::min(share, 1.0) * Bonded::kFriction * normal, 1e-6 * normal);
    const std::vector<double> p = random_field(b.scene, 1, 5),
                              away = random_field(b.scene, 1e-7, 4);
    for (size_t k = 0; k < at.size(); ++k) at[k] += away[k];
    b.energy(at);
    const std::vector<double> gradient = b.g;
    std::vector<double> plus = at, minus = at;
    const double e = 1e-9;
    for (size_t k = 0; k < at.size(); ++k) plus[k] += e * p[k], minus[k] -= e * p[k];
    EXPECT_NEAR((b.energy(plus) - b.energy(minus)) / (2 * e), dot(gradient, p),
                1e-5 * norm(gradient) * norm(p));
  }
}

TEST(Contact, BondsKeepTheirForceFromStepToStepAsFarAsTheyHold) {
  Bonded b;
  b.begin(b.u, 0);
  const double normal = b.pull(b.u).second, most = Bonded::kFriction * normal;
  const double holds = 1e-7 * most / b.pull(b.pushed(1e-7)).first;
  const auto next = [&](double way, double time) {
    const std::vector<double> end = b.pushed(way);
    b.contact.keep_bonds(end.data());
    b.begin(end, time);
  };
  next(0.6 * holds, 0.01);
  EXPECT_NEAR(b.pull(b.u).first, 0.6 * most, 1e-6 * most);
  EXPECT_NEAR(b.pull(b.pushed(10 * holds)).first, most, 1e-6 * most);
  // what slid is let go: turning back by what a bond holds takes the force off
  next(10 * holds, 0.02);
  EXPECT_NEAR(b.pull(b.u).first, most, 1e-6 * most);
  EXPECT_NEAR(b.pull(b.pushed(-holds)).first, 0, 1e-6 * most);
  b.contact.forget_bonds();
  b.begin(b.u, 0.03);
  EXPECT_EQ(b.pull(b.u).first, 0);
}

}  // namespace
}  // namespace elastogen::test
