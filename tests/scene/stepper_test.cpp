// SPDX-License-Identifier: Apache-2.0
// The network against finite elements on the same element: two implementations of one potential.
#include "scene/stepper.hpp"

#include "core/error.hpp"
#include "mpm_fem/fem/elastic_body.hpp"
#include "scene/fem_scene.hpp"
#include "scene/particle_setup.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

constexpr int kSteps = 6;

RunDescription network(double tolerance) {
  RunDescription options;
  options.solver.mode = SolverMode::kNewton;
  options.energy = EnergySource::kAnalytic;
  options.solver.tolerance = tolerance;
  options.solver.follows_time_error = false;
  return options;
}

RunDescription finite_elements(fem::Element element) {
  RunDescription options;
  options.fem = FemOptions{.element = element, .mass = fem::Mass::kLumped, .newmark = false};
  options.solver.tolerance = 1e-9;
  options.solver.follows_time_error = false;
  return options;
}

Setup setup_of(const Scene& scene) {
  Setup setup;
  setup.scene = scene;
  return setup;
}

/// Positions after some steps, each of which must converge.
State end_of(const Scene& scene, const RunDescription& options, const StartMotion& motion) {
  const Setup setup = setup_of(scene);
  std::vector<std::string> notes;
  const std::unique_ptr<Stepper> stepper = make_stepper(setup, options, {}, notes);
  EXPECT_TRUE(notes.empty());
  stepper->begin(motion);
  for (int n = 0; n < kSteps; ++n) {
    const StepReport report = stepper->advance();
    EXPECT_TRUE(report.converged) << "step " << n << ": " << report.residual;
  }
  return stepper->state();
}

/// Largest distance of two states' nodes over the largest displacement.
double difference(const Scene& scene, const State& a, const State& b) {
  double distance = 0, displacement = 0;
  for (int64_t k = 0; k < scene.grid.rest.size(); ++k) {
    distance = std::max(distance, std::abs(a.x.data()[k] - b.x.data()[k]));
    displacement = std::max(displacement, std::abs(b.x.data()[k] - scene.grid.rest.data()[k]));
  }
  return distance / displacement;
}

void expect_the_same(const Scene& scene, const StartMotion& motion = {}) {
  const State fem = end_of(scene, finite_elements(fem::Element::kVoxel), motion);
  const State net = end_of(scene, network(1e-8), motion);
  const double apart = difference(scene, net, fem);
  std::printf("network and finite elements are %.1e apart\n", apart);
  EXPECT_LT(apart, 1e-7);
}

/// Random fills and shape means, two materials, pinned below.
Scene ragged_scene(Law law, Hourglass hourglass, TimeScheme scheme) {
  Scene scene = scene_on(ragged_grid(7, 4, 4, 0.05, 3), solid(2e5, 0.4, law));
  scene.materials.push_back(solid(2e6, 0.3, law, 400));
  for (int64_t v = 0; v < scene.material.rows(); ++v) scene.material(v) = int32_t(v % 2);
  pin_below(scene, 0, -0.1);
  scene.gravity = {1, -9.81, 2};
  scene.hourglass = hourglass;
  scene.scheme = scheme;
  finish_scene(scene);
  return scene;
}

TEST(Stepper, NetworkAndFiniteElementsAgreeForEveryLaw) {
  for (const Law law :
       {Law::kFixedCorotated, Law::kNeoHookean, Law::kStableNeoHookean, Law::kHencky})
    expect_the_same(ragged_scene(law, Hourglass::kFull, TimeScheme::kEuler));
}

TEST(Stepper, NetworkAndFiniteElementsAgreeForBdf2AndWithoutTorsion) {
  expect_the_same(ragged_scene(Law::kNeoHookean, Hourglass::kFull, TimeScheme::kBdf2));
  expect_the_same(ragged_scene(Law::kNeoHookean, Hourglass::kVariance, TimeScheme::kEuler));
}

/// A box of free voxels that yields.
Setup yielding_setup(const Yield& yield) {
  Scene scene = scene_on(make_box(3, 3, 3, 0.02), solid(1e7, 0.3));
  scene.dt = 2e-3;
  scene.gravity = {};
  finish_scene(scene);
  Setup setup = setup_of(scene);
  setup.yields = {yield};
  return setup;
}

TEST(Stepper, NetworkAndFiniteElementsAgreeForStages) {
  for (const TimeScheme scheme : {TimeScheme::kSdirk2, TimeScheme::kAuto})
    expect_the_same(ragged_scene(Law::kNeoHookean, Hourglass::kFull, scheme));
}

TEST(Stepper, FiniteElementsReportTheirStages) {
  // a body that swings fast: steps of two stages, which make up the frames
  Scene scene = ragged_scene(Law::kNeoHookean, Hourglass::kFull, TimeScheme::kAuto);
  scene.dt = 1.0 / 30;
  const auto setup = setup_of(scene);
  RunDescription run = finite_elements(fem::Element::kVoxel);
  run.solver.tolerance = 1e-5;
  run.solver.time_error = 1e-3;
  std::vector<std::string> notes;
  const std::unique_ptr<Stepper> stepper = make_stepper(setup, run, {}, notes);
  stepper->begin({});
  int frames = 0, rejected = 0;
  double time = 0;
  while (frames < 3) {
    const StepReport r = stepper->advance();
    time += r.length;
    frames += r.completes;
    rejected += r.rejected;
    EXPECT_TRUE(r.converged);
    EXPECT_EQ(r.scheme, TimeScheme::kSdirk2);
    EXPECT_EQ(r.solves, 2 * (1 + r.rejected));
    EXPECT_GT(r.time_error, 0);
    EXPECT_LE(r.time_ratio, 1);
    EXPECT_GE(r.tolerance, 1e-5);
    EXPECT_NEAR(r.time, time, 1e-12);
    EXPECT_EQ(stepper->state().time, r.time);
    EXPECT_EQ(stepper->state().h_before, r.length);
  }
  EXPECT_GT(rejected, 0);
  EXPECT_NEAR(time, 0.1, 1e-12);
}

TEST(Stepper, StagesHandOutTheirFirstOneAndTheBonds) {
  // a free fall, whose first stage ends as a step of implicit Euler of length k would
  Scene scene = scene_on(make_box(2, 2, 2, 0.1), solid(1e6, 0.3));
  scene.gravity = {1, -9.81, 2};
  scene.dt = 0.02;
  scene.scheme = TimeScheme::kSdirk2;
  scene.surface = face_points(scene.grid);
  scene.colliders = {half_space({0, 1, 0}, -5, 0.5), half_space({1, 0, 0}, -5, 0)};
  finish_scene(scene);
  const auto setup = setup_of(scene);
  const StartMotion motion{.velocity = {0.5, 1, -2}};
  const double k = kSdirkStage * scene.dt;
  for (const RunDescription& run : {finite_elements(fem::Element::kVoxel), network(1e-8)}) {
    std::vector<std::string> notes;
    const std::unique_ptr<Stepper> stepper = make_stepper(setup, run, {}, notes);
    stepper->begin(motion);
    ASSERT_TRUE(stepper->advance().converged);
    stepper->state();
    const StageData data = stepper->stage_data();
    ASSERT_TRUE(data.first.is(scene.grid.node_count(), 3));
    EXPECT_TRUE(data.bonds.is(2 * scene.surface.voxel.rows(), 3));
    for (int64_t n = 0; n < scene.grid.node_count(); ++n)
      for (int d = 0; d < 3; ++d)
        EXPECT_NEAR(
            data.first(n, d),
            scene.grid.rest(n, d) + k * motion.velocity[d] + k * k * scene.gravity[size_t(d)],
            1e-11);
  }
}

TEST(Stepper, StagesAreRefusedWithoutAWayBack) {
  // a body that yields, statics
  auto setup = yielding_setup(MetalYield{.stress = 2e3});
  setup.scene.scheme = TimeScheme::kAuto;
  RunDescription run = finite_elements(fem::Element::kHexBbar);
  std::vector<std::string> notes;
  EXPECT_THROW(make_stepper(setup, run, {}, notes), Error);
  setup.yields = {};
  run.state = "state.h5";
  EXPECT_NE(make_stepper(setup, run, {}, notes), nullptr);
  run.state = {};
  run.fem->statics = true;
  EXPECT_THROW(make_stepper(setup, run, {}, notes), Error);
}

/// A box that falls on a rough floor which moves, under a ball.
Scene contact_scene() {
  Scene scene = scene_on(make_box(5, 3, 3, 0.04, {0, 0.005, 0}), solid(1e5, 0.4));
  scene.surface = face_points(scene.grid);
  Collider floor = half_space({0, 1, 0}, 0, 0.4), ball;
  floor.path = {{0, {}}, {0.1, {0.01, 0.01, 0}}};
  ball.name = "ball", ball.shape = Collider::Shape::kSphere;
  ball.centre = {0.1, 0.2, 0.06}, ball.radius = 0.06, ball.friction = 0.2;
  ball.path = {{0, {}}, {0.1, {0, -0.04, 0}}};
  scene.colliders = {floor, ball};
  scene.gravity = {0, -9.81, 0};
  finish_scene(scene);
  return scene;
}

TEST(Stepper, NetworkAndFiniteElementsAgreeInContactWithFriction) {
  Scene scene = contact_scene();
  for (const TimeScheme scheme : {TimeScheme::kEuler, TimeScheme::kSdirk2, TimeScheme::kAuto}) {
    scene.scheme = scheme;
    expect_the_same(scene, {.velocity = {0.2, -0.5, 0}, .spin = {0, 1, 0}});
  }
}

/// Other elements see the same body and load: close, not equal.
TEST(Stepper, OtherElementsComeNear) {
  Scene scene = clamped_beam(12, 3, 3, 1.0 / 30, solid(3e5, 0.3));
  const State voxel = end_of(scene, finite_elements(fem::Element::kVoxel), {});
  for (const fem::Element element : {fem::Element::kHexBbar, fem::Element::kTet10}) {
    const State other = end_of(scene, finite_elements(element), {});
    ASSERT_GE(other.x.rows(), scene.grid.node_count());
    const double apart = difference(scene, other, voxel);
    EXPECT_LT(apart, 0.03) << fem::element_name(element);
    EXPECT_GT(apart, 1e-5) << fem::element_name(element);
  }
}

/// With every element a body has the mass of the scene, border voxels included.
TEST(Stepper, EveryElementHasTheMassOfTheScene) {
  const Scene scene = ragged_scene(Law::kNeoHookean, Hourglass::kFull, TimeScheme::kEuler);
  double mass = 0;
  for (int64_t n = 0; n < scene.mass.rows(); ++n) mass += scene.mass(n);
  for (const fem::Element element :
       {fem::Element::kVoxel, fem::Element::kHex, fem::Element::kTet4, fem::Element::kTet10})
    for (const fem::Mass kind : {fem::Mass::kLumped, fem::Mass::kConsistent}) {
      RunDescription options = finite_elements(element);
      options.fem->mass = kind;
      const fem::FemScene body = fem_scene(setup_of(scene), options);
      const fem::ElasticBody elastic(body.mesh, body.materials);
      const Array<double> lumped = elastic.lumped_mass();
      double sum = 0, consistent = 0, M[100];
      for (int64_t n = 0; n < lumped.rows(); ++n) sum += lumped(n);
      for (int64_t e = 0; e < body.mesh.elements.rows(); ++e) {
        elastic.element_mass(e, M);
        const int nodes = fem::nodes_of(element);
        for (int k = 0; k < nodes * nodes; ++k) consistent += M[k];
      }
      EXPECT_NEAR(sum, mass, 1e-12 * mass) << fem::element_name(element);
      EXPECT_NEAR(consistent, mass, 1e-12 * mass) << fem::element_name(element);
    }
}

/// Tetrahedra carry the same contact points.
TEST(Stepper, ASpinBeyondYieldLeavesAPlasticState) {
  RunDescription run = finite_elements(fem::Element::kHexBbar);
  run.yield = MetalYield{.stress = 2e3};
  const auto setup = yielding_setup(run.yield);
  std::vector<std::string> notes;
  const std::unique_ptr<Stepper> stepper = make_stepper(setup, run, {}, notes);
  StartMotion spin;
  spin.spin[1] = 200;
  stepper->begin(spin);
  StepReport report;
  for (int n = 0; n < 10; ++n) report = stepper->advance();
  EXPECT_TRUE(report.yields);
  EXPECT_GT(report.energy.plastic, 0);
  const std::optional<StatePlastic> plastic = stepper->plastic();
  ASSERT_TRUE(plastic);
  EXPECT_EQ(plastic->Fp_inverse.rows(), 27 * 8);
  EXPECT_EQ(plastic->yields(0, 0), 1);
  EXPECT_EQ(plastic->yields(0, 1), 2e3);
}

TEST(Stepper, ParticlesAndTheNetworkRefuseWhatTheyCannotStep) {
  RunDescription run;
  run.yield = SandYield{};
  const auto setup = yielding_setup(run.yield);
  std::vector<std::string> notes;
  EXPECT_THROW(make_stepper(setup, run, {}, notes), Error);
  run.method = Method::kFem;
  EXPECT_THROW(make_stepper(setup, run, {}, notes), Error);
}

/// A cube of sand in the air, two voxels above a floor at `ground`.
Setup sand_above_a_floor(const RunDescription& run, double& ground) {
  auto setup = yielding_setup(run.yield);
  Scene& scene = setup.scene;
  scene.gravity = {0, -10, 0};
  scene.dt = 5e-3;
  ground = 1e300;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    ground = std::min(ground, scene.grid.rest(n, 1) - 2 * scene.grid.h);
  scene.colliders = {half_space({0, 1, 0}, ground, 0.5)};
  add_particles({}, run, setup);
  return setup;
}

TEST(Stepper, ParticlesHaveTheMassOfTheBody) {
  RunDescription run;
  run.yield = SandYield{};
  double ground;
  const auto setup = sand_above_a_floor(run, ground);
  const VoxelGrid& grid = setup.scene.grid;
  double mass = 0, volume = 0;
  for (int64_t k = 0; k < setup.particles->particles.count(); ++k)
    mass += setup.particles->particles.mass(k);
  for (int64_t v = 0; v < grid.voxel_count(); ++v) volume += grid.fill(v) * std::pow(grid.h, 3);
  EXPECT_NEAR(mass, volume * setup.scene.materials[0].density, 1e-12 * mass);
}

TEST(Stepper, SandFallsAndLiesOnAFloor) {
  RunDescription run;
  run.yield = SandYield{};
  double ground;
  const auto setup = sand_above_a_floor(run, ground);
  const double h = setup.scene.grid.h;
  std::vector<std::string> notes;
  const std::unique_ptr<Stepper> stepper = make_stepper(setup, run, {}, notes);
  stepper->begin({});
  EXPECT_TRUE(stepper->advance().converged);
  for (int64_t k = 0; k < stepper->state().v.rows(); ++k)
    EXPECT_NEAR(stepper->state().v(k, 1), -10 * 5e-3, 1e-6);
  StepReport report;
  for (int n = 0; n < 100; ++n) {
    report = stepper->advance();
    EXPECT_TRUE(report.converged) << n << ": " << report.residual;
  }
  EXPECT_LT(report.deepest_overlap, 1);
  double highest = -1e300;
  for (int64_t k = 0; k < stepper->state().x.rows(); ++k)
    highest = std::max(highest, stepper->state().x(k, 1));
  EXPECT_LT(highest, ground + 3 * h);
  EXPECT_GT(highest, ground + h / 2);
}

TEST(Stepper, ParticlesAreHeldByPlaceAndRefuseToBeAGlb) {
  RunDescription run;
  run.yield = SandYield{};
  auto setup = yielding_setup(run.yield);
  run.pins = {parse_pin("all")};
  EXPECT_THROW(add_particles({}, run, setup), Error);
  run.pins = {parse_pin("y<5%")};
  add_particles({}, run, setup);
  // as positions, the border counts from the grid's origin
  const Box& box = setup.body.surface.box;
  ASSERT_EQ(setup.particles->held.size(), 1u);
  EXPECT_NEAR(setup.particles->held[0].upper[1] + setup.scene.grid.origin[1],
              box.lower[1] + 0.05 * (box.upper[1] - box.lower[1]), 1e-12);
  run.pins.clear();
  run.outputs = {"a.glb"};
  EXPECT_THROW(add_particles({}, run, setup), Error);
}

TEST(Stepper, TetrahedraRestOnAFloor) {
  Scene scene = contact_scene();
  for (Collider& c : scene.colliders) c.path = {};
  const State voxel = end_of(scene, finite_elements(fem::Element::kVoxel), {});
  for (const fem::Element element : {fem::Element::kTet4, fem::Element::kTet10}) {
    const fem::FemScene tets = fem_scene(setup_of(scene), finite_elements(element));
    for (int64_t p = 0; p < tets.contact.weights.rows(); ++p) {
      double sum = 0, place[3] = {};
      for (int a = 0; a < tets.contact.weights.cols(); ++a) {
        sum += tets.contact.weights(p, a);
        for (int d = 0; d < 3; ++d)
          place[d] += tets.contact.weights(p, a) * tets.mesh.rest(tets.contact.nodes(p, a), d);
      }
      EXPECT_NEAR(sum, 1, 1e-12);
      for (int d = 0; d < 3; ++d) EXPECT_NEAR(place[d], scene.surface.position(p, d), 1e-12);
    }
    EXPECT_LT(difference(scene, end_of(scene, finite_elements(element), {}), voxel), 0.1);
  }
}

}  // namespace
}  // namespace elastogen::test
