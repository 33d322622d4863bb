// SPDX-License-Identifier: Apache-2.0
// Particles and their grid: conservation by transfers, and steps against closed forms.

#include "core/error.hpp"
#include "core/reduce.hpp"
#include "mpm_fem/fem/inversion_bound.hpp"
#include "mpm_fem/integrators/explicit_mpm.hpp"
#include "mpm_fem/integrators/implicit_mpm.hpp"
#include "mpm_fem/mpm/fill.hpp"
#include "mpm_fem/mpm/g2p.hpp"
#include "tests/mpm_fem/particle_scenes.hpp"
#include "voxelize/bricks.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace elastogen::mpm {
namespace {

using test::kH, test::particle_scene, test::particle_solid, test::random_particles;

/// Mass, momentum and angular momentum of the nodes.
template <int d>
Momentum momentum_of(const ParticleGrid<d>& grid, const NodeMotion& nodes, In<double> velocity) {
  Momentum total;
  for (int64_t i = 0; i < grid.nodes(); ++i) {
    const double m = nodes.mass(i), *v = velocity.row(i);
    total.mass += m;
    for (size_t a = 0; a < 3; ++a) {
      const size_t b = (a + 1) % 3, c = (a + 2) % 3;
      total.linear[a] += m * v[a];
      total.angular[a] += m * kH * (grid.place(i)[b] * v[c] - grid.place(i)[c] * v[b]);
    }
  }
  return total;
}

void expect_same(const Momentum& a, const Momentum& b) {
  EXPECT_NEAR(a.mass, b.mass, 1e-12 * b.mass);
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_NEAR(a.linear[k], b.linear[k], 1e-12 * b.mass);
    EXPECT_NEAR(a.angular[k], b.angular[k], 1e-12 * b.mass);
  }
}

/// Velocities of particles after ten steps beside what holds them.
template <int d>
Array<double> held_by(const Obstacle& obstacle) {
  MpmScene scene = particle_scene(d);
  scene.gravity = {0, -10, 0};
  scene.obstacles = {obstacle};
  Particles p = random_particles<d>(500, 4);
  ExplicitMpm<d> steps(scene);
  for (int k = 0; k < 10; ++k) steps.step(k * scene.dt, p);
  return p.v;
}

TEST(ObstacleContact, APinHoldsAsAWallThatSticksDoes) {
  Obstacle wall, pin;
  wall.collider.shape = Collider::Shape::kPlane;
  wall.collider.normal = {0, 1, 0};
  wall.collider.centre = {0, -0.2, 0};
  wall.sticky = true;
  const double all = std::numeric_limits<double>::infinity();
  pin.held = {.lower = {-all, -all, -all}, .upper = {all, -0.2, all}, .is_plane = true};
  EXPECT_EQ(held_by<2>(pin), held_by<2>(wall));
  EXPECT_EQ(held_by<3>(pin), held_by<3>(wall));
}

TEST(Spline, IsAPartitionOfUnityThatMeetsAffineFields) {
  test::Random random(3);
  std::uniform_real_distribution<double> in(-2, 2);
  for (int k = 0; k < 10000; ++k) {
    double x[3] = {in(random), in(random), in(random)};
    if (k % 10 == 0) x[0] = kH * std::round(x[0] / kH), x[1] = kH * (std::round(x[1] / kH) + 0.5);
    const Spline<3> s = spline<3>(x, kH);
    double sum = 0, slope[3] = {}, away[3] = {}, spread = 0;
    for_nodes<3, 3>(s, 0, [&](int, double w, const double g[3], const double r[3]) {
      EXPECT_GE(w, 0);
      sum += w, spread += w * r[0] * r[0];
      for (int a = 0; a < 3; ++a) slope[a] += g[a], away[a] += w * r[a];
    });
    EXPECT_NEAR(sum, 1, 1e-14);
    EXPECT_NEAR(spread, kH * kH / 4, 1e-14);
    for (int a = 0; a < 3; ++a) {
      EXPECT_NEAR(slope[a], 0, 1e-13 / kH);
      EXPECT_NEAR(away[a], 0, 1e-14);
    }
  }
}

template <int d>
void check_transfers() {
  Particles p = random_particles<d>(2000, 5);
  ParticleGrid<d> grid(kH);
  Zeroed<double> scratch;
  grid.update(p.x);
  const NodeMotion nodes = particles_to_grid<d>(grid, p, scratch);
  const Momentum of_particles = momentum(p, kH);
  expect_same(momentum_of(grid, nodes, nodes.velocity), of_particles);
  // back with the nodes' velocities; places stay, so that both are about the same points
  const Array<double> none(grid.nodes(), 3);
  for (const Transfer kind : {Transfer::kApic, Transfer::kBlend}) {
    Particles back = p;
    grid_to_particles<d>(grid, none, nodes.velocity, nodes.velocity, {.kind = kind}, 1e-3, back);
    expect_same(momentum(back, kH), of_particles);
    EXPECT_LE(kinetic_energy(back, kH), kinetic_energy(p, kH));
  }
}

TEST(Transfer, KeepsMassMomentumAndAngularMomentum) {
  check_transfers<2>();
  check_transfers<3>();
}

TEST(Transfer, KeepsAffineVelocityFields) {
  Particles p = random_particles<3>(3000, 6);
  const double A[9] = {0.3, -1, 0.2, 0.5, 0.1, -0.4, 0.7, -0.2, -0.6};
  for (int64_t k = 0; k < p.count(); ++k)
    for (int a = 0; a < 3; ++a) {
      p.v(k, a) = 1;
      for (int b = 0; b < 3; ++b)
        p.v(k, a) += A[3 * a + b] * p.x(k, b), p.C(k, 3 * a + b) = A[3 * a + b];
    }
  const Particles start = p;
  ParticleGrid<3> grid(kH);
  Zeroed<double> scratch;
  grid.update(p.x);
  const NodeMotion nodes = particles_to_grid<3>(grid, p, scratch);
  const Array<double> none(grid.nodes(), 3);
  grid_to_particles<3>(grid, none, nodes.velocity, nodes.velocity, {}, 1e-3, p);
  for (int64_t k = 0; k < p.v.size(); ++k) EXPECT_NEAR(p.v.data()[k], start.v.data()[k], 1e-12);
  for (int64_t k = 0; k < p.C.size(); ++k) EXPECT_NEAR(p.C.data()[k], start.C.data()[k], 1e-11);
}

TEST(ParticleGrid, RefusesPointsThatAreNotFinite) {
  Array<double> x(1, 3);
  x(0, 1) = std::nan("");
  ParticleGrid<3> grid(kH);
  EXPECT_THROW(grid.update(x), Error);
}

TEST(ParticleGrid, IsTheSameAfterItsPointsMovedAsFromNothing) {
  Particles p = random_particles<3>(2000, 8);
  ParticleGrid<3> grid(kH), fresh(kH);
  grid.update(p.x);
  for (int64_t k = 0; k < p.x.size(); ++k) p.x.data()[k] += 0.3 * p.v.data()[k];
  grid.update(p.x);
  fresh.update(p.x);
  ASSERT_EQ(grid.nodes(), fresh.nodes());
  EXPECT_EQ(grid.order(), fresh.order());
  for (int64_t i = 0; i < grid.nodes(); ++i) EXPECT_EQ(grid.place(i), fresh.place(i));
}

TEST(Fill, HasTheMassOfTheVoxelsAndPlacesWithinThem) {
  // one voxel is filled by 0.3
  VoxelGrid grid = make_box(3, 2, 2, kH);
  grid.fill(0) = 0.3;
  grid.volume = 0;
  const Array<int32_t> material(grid.voxel_count());
  const std::vector<Solid> solids = {particle_solid(1e4, 800)};
  const Filled filled = fill_body(grid, material, solids);
  const Particles& p = filled.particles;
  EXPECT_EQ(p.x, fill_body(grid, material, solids).particles.x);
  EXPECT_FALSE(p.x == fill_body(grid, material, solids, {.seed = 2}).particles.x);
  EXPECT_EQ(p.count(), 11 * 8 + 2);
  // each particle lies in its voxel and in no other
  std::vector<double> mass(size_t(grid.voxel_count()));
  for (int64_t k = 0; k < p.count(); ++k) {
    int found = 0;
    for (int64_t v = 0; v < grid.voxel_count(); ++v) {
      bool inside = true;
      for (int a = 0; a < 3; ++a) {
        const double at = p.x(k, a) / kH - grid.voxel_coord(v, a);
        inside &= at >= 0 && at <= 1;
      }
      if (!inside) continue;
      ++found;
      EXPECT_EQ(filled.voxel(k), v);
      mass[size_t(v)] += p.mass(k);
    }
    EXPECT_EQ(found, 1);
  }
  // masses of the voxels, and of a body of known volume
  for (int64_t v = 0; v < grid.voxel_count(); ++v)
    EXPECT_NEAR(mass[size_t(v)], 800 * grid.fill(v) * kH * kH * kH, 1e-12);
  grid.volume = 0.015;  // of the asset, which voxels only come near
  EXPECT_NEAR(momentum(fill_body(grid, material, solids).particles, kH).mass, 800 * 0.015, 1e-12);
}

TEST(InversionBound, StopsShortOfTheFirstRootOfTheDeterminant) {
  test::Random random(9);
  int bounded = 0;
  for (int k = 0; k < 2000; ++k) {
    const Mat3<double> A = test::gaussian(random), I = identity<double>();
    const auto at = [&](double t) {
      Mat3<double> F = I;
      for (int e = 0; e < 9; ++e) F.m[e] += t * A.m[e];
      return F;
    };
    const double share = fem::share_before_inversion(I, at(1));
    if (share < 1) {
      ++bounded;
      EXPECT_NEAR(determinant(at(share / 0.9)), 0.1, 1e-7);
    }
    for (int n = 0; n < 200; ++n) EXPECT_GE(determinant(at(share * n / 200)), 0.1 - 1e-7);
  }
  EXPECT_GT(bounded, 200);
}

/// The assembled Jacobian, the matrix-free one and differences of the residual agree, in a state
/// that yields and slides along a plane.
template <int d>
void check_jacobian() {
  // sand that yields between two planes
  MpmScene s = particle_scene(d);
  s.solids[0].yield = SandYield{.friction = 0.5, .keeps_volume = false};
  s.gravity = {2, -10, 0};
  s.obstacles.push_back({half_space({0, 1, 0}, -0.35, 0.2), false});
  s.obstacles.push_back({half_space({1, 0, 0}, -0.35, 0.2), true});
  const Particles p = random_particles<d>(d == 2 ? 400 : 1500, 14);
  MpmEquations<d> equations(s);
  equations.begin(p, 0, 5e-3);
  const auto size = size_t(equations.unknowns());
  std::vector<double> y(size), r(size), way(size), product(size), matrix(size), ends[2];
  equations.predict(y.data());
  test::Random random(15);
  std::normal_distribution<double> normal;
  for (size_t k = 0; k < size; ++k) way[k] = k % 3 < d ? normal(random) : 0;
  // the residual, and both products with the Jacobian
  equations.residual(y.data(), r.data());
  equations.linearise(y.data());
  equations.product(way.data(), product.data());
  fem::multiply(equations.jacobian(), way.data(), matrix.data());
  // central differences along the direction
  const double step = 1e-7;
  for (const int end : {0, 1}) {
    std::vector<double> moved = y;
    for (size_t k = 0; k < size; ++k) moved[k] += (end ? step : -step) * way[k];
    ends[end] = r;
    equations.residual(moved.data(), ends[end].data());
  }
  double off = 0, apart = 0, most = 0;
  for (size_t k = 0; k < size; ++k) {
    most = std::max(most, std::abs(product[k]));
    apart = std::max(apart, std::abs(product[k] - matrix[k]));
    off += std::pow(product[k] - (ends[1][k] - ends[0][k]) / (2 * step), 2);
  }
  EXPECT_LT(apart, 1e-12 * most);
  EXPECT_LT(std::sqrt(off), 1e-5 * norm(product.data(), int64_t(size)));
}

TEST(MpmEquations, JacobianIsTheDerivativeOfTheResidual) {
  check_jacobian<2>();
  check_jacobian<3>();
}

/// A free body keeps its momenta, explicit and implicit, and so does one that yields.
TEST(Mpm, FreeFlightKeepsMomentumAndAngularMomentum) {
  MpmScene s = particle_scene(3);
  for (const bool metal : {false, true}) {
    if (metal) s.solids[0].yield = MetalYield{.stress = 200};
    Particles p = random_particles<3>(2000, 10);
    const Momentum start = momentum(p, kH);
    ExplicitMpm<3> explicit_steps(s);
    ImplicitMpm<3> implicit_steps(s, {.tolerance = 1e-9});
    for (int k = 0; k < 5; ++k) explicit_steps.step(0, p);
    for (int k = 0; k < 3; ++k) EXPECT_TRUE(implicit_steps.step(0, p).converged);
    const Momentum end = momentum(p, kH);
    EXPECT_NEAR(end.mass, start.mass, 1e-12 * start.mass);
    for (size_t a = 0; a < 3; ++a) {
      EXPECT_NEAR(end.linear[a], start.linear[a], 1e-9 * start.mass);
      EXPECT_NEAR(end.angular[a], start.angular[a], 1e-7 * start.mass);
    }
  }
}

/// Both follow the parabola of a body in free fall: of Euler's steps, y = g t (t + dt)/2.
TEST(Mpm, FallsFreely) {
  MpmScene s = particle_scene(2);
  s.gravity = {0, -10, 0};
  for (const bool implicit_step : {false, true}) {
    Particles p = random_particles<2>(400, 11);
    p.v.fill(0), p.C.fill(0);
    const Array<double> start = p.x;
    ExplicitMpm<2> explicit_steps(s);
    ImplicitMpm<2> implicit_steps(s, {.tolerance = 1e-9});
    for (int k = 0; k < 20; ++k)
      implicit_step ? (void)implicit_steps.step(0, p) : explicit_steps.step(0, p);
    const double fallen = 10 * 0.02 * 0.021 / 2;
    for (int64_t k = 0; k < p.count(); ++k) EXPECT_NEAR(p.x(k, 1), start(k, 1) - fallen, 1e-9);
  }
}

/// With ever smaller substeps the explicit step tends to the exact one, and the implicit one is
/// first order off it.
Particles sheared(const MpmScene& s, int substeps) {
  Particles p = random_particles<2>(800, 12);
  for (int64_t k = 0; k < p.count(); ++k) {
    p.v(k, 0) = 0.5 * p.x(k, 1), p.v(k, 1) = -0.2 * p.x(k, 1);
    for (int a = 0; a < 9; ++a) p.C(k, a) = 0;
    p.C(k, 1) = 0.5, p.C(k, 4) = -0.2;
  }
  if (substeps > 0) {
    ExplicitMpm<2>(s, substeps).step(0, p);
  } else {
    EXPECT_TRUE(ImplicitMpm<2>(s, {.tolerance = 1e-8}).step(0, p).converged);
  }
  return p;
}

double distance(const Particles& a, const Particles& b) {
  double most = 0;
  for (int64_t k = 0; k < a.x.size(); ++k)
    most = std::max(most, std::abs(a.v.data()[k] - b.v.data()[k]));
  return most;
}

TEST(Mpm, SubstepsConvergeAndTheImplicitStepIsFirstOrder) {
  MpmScene s = particle_scene(2);
  s.solids[0].yield = SandYield{.friction = 0.5, .keeps_volume = false};
  s.dt = 4e-3;
  const Particles fine = sheared(s, 800);
  const double coarse = distance(sheared(s, 50), fine), finer = distance(sheared(s, 100), fine);
  EXPECT_NEAR(coarse / finer, 2.1, 0.3);
  std::vector<double> error;
  for (const double dt : {4e-3, 2e-3}) {
    s.dt = dt;
    error.push_back(distance(sheared(s, 0), sheared(s, 800)));
  }
  EXPECT_GT(error[0] / error[1], 2.5);  // of one step: second order
}

/// A block on an incline, with Coulomb's friction at the nodes: it holds below the angle of
/// friction and slides above it with g (sin - mu cos).
TEST(Mpm, SlidesOnAnInclineByCoulombsLaw) {
  for (const double friction : {0.3, 0.7}) {
    MpmScene s = particle_scene(2);
    s.solids[0] = particle_solid(1e8, 1000);  // so stiff that it hardly oscillates
    const double angle = std::atan(0.5), g = 10;
    s.gravity = {g * std::sin(angle), -g * std::cos(angle), 0};
    s.obstacles.push_back({half_space({0, 1, 0}, 0, friction), false});
    Array<double> x(10 * 40, 3);
    for (int64_t k = 0; k < x.rows(); ++k)
      x(k, 0) = 0.025 + 0.05 * double(k % 40), x(k, 1) = 0.025 + 0.05 * double(k / 40);
    Particles p = particles_at(x, 0.05 * 0.05, 0, 1000);
    ImplicitMpm<2> steps(s, {.tolerance = 1e-6});
    for (int k = 0; k < 50; ++k) EXPECT_TRUE(steps.step(k * s.dt, p).converged);
    const Momentum end = momentum(p, kH);
    const double expected =
        friction < 0.5 ? g * 0.05 * (std::sin(angle) - friction * std::cos(angle)) : 0;
    EXPECT_NEAR(end.linear[0] / end.mass, expected, 0.02 * g * 0.05 * std::sin(angle));
  }
}

/// Reports where Newton's method does not reach its tolerance, or GMRES does not reach its own.
TEST(Mpm, ImplicitStepsSayWhatTheyMissAndWhatTheyFactored) {
  MpmScene s = test::column_scene(test::sand(1e8), 1e-2);
  const auto step = [&](const ImplicitMpmOptions& options) {
    Particles p = test::column(4, 8);
    return ImplicitMpm<2>(s, options).step(0, p);
  };
  const MpmStepReport few = step({.max_newton = 2});
  EXPECT_FALSE(few.converged);
  EXPECT_TRUE(few.finite);
  EXPECT_EQ(few.stop, fem::RootStop::kIterations);
  EXPECT_EQ(few.outer, 2);
  EXPECT_GT(few.residual, 1e-3);
  const MpmStepReport factored = step({}),
                      krylov = step({.max_iterations = 4000, .most_factored = 0});
  EXPECT_TRUE(factored.converged);
  EXPECT_GT(factored.factored, 0);
  EXPECT_TRUE(krylov.converged);
  EXPECT_EQ(krylov.factored, 0);
}

}  // namespace
}  // namespace elastogen::mpm
