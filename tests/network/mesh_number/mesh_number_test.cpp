// SPDX-License-Identifier: Apache-2.0
#include "network/mesh_number/mesh_number.hpp"

#include "network/solver.hpp"
#include "network/step/newton_solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using test::scene_on;
using test::solid;

/// Points at all nodes of a grid.
Embedding at_nodes(const VoxelGrid& grid) {
  return embed(grid, grid.rest);
}

Mat3<double> rotation(double angle) {
  return rotation_matrix(Quaternion<double>{std::cos(angle / 2), std::sin(angle / 2) / std::sqrt(3),
                                            std::sin(angle / 2) / std::sqrt(3),
                                            std::sin(angle / 2) / std::sqrt(3)});
}

/// A X + b at every node.
Array<double> affine(const VoxelGrid& grid, const Mat3<double>& A, const Vec3& b) {
  Array<double> x(grid.node_count(), 3);
  for (int64_t n = 0; n < x.rows(); ++n) {
    const double* X = grid.rest.row(n);
    const Vec3 moved = plus(times(A, {X[0], X[1], X[2]}), b);
    std::copy_n(moved.begin(), 3, x.row(n));
  }
  return x;
}

/// A ball that is cut by its grid, of two materials where asked for.
Scene free_ball(bool two_materials = false) {
  Scene scene = scene_on(test::ball_grid(0.1, 0.021), solid(1e5, 0.3));
  if (two_materials) {
    scene.materials.push_back(solid(1e6, 0.4, Law::kNeoHookean, 3000));
    for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
      scene.material(v) = scene.grid.voxel_coord(v, 0) > 0;
  }
  finish_scene(scene);
  return scene;
}

TEST(MeshNumber, IsZeroInFlightAndSpin) {
  for (const bool two : {false, true}) {
    const Scene scene = free_ball(two);
    const Embedding points = at_nodes(scene.grid);
    MeshNumber number(scene, 0.03);
    number.begin(scene.grid.rest);
    for (int frame = 1; frame <= 10; ++frame) {
      const Array<double> x =
          affine(scene.grid, rotation(0.7 * frame), {0.4 * frame, -0.05 * frame * frame, 0});
      const MeshError error = number.estimate(x, 0.03, points);
      EXPECT_LT(error.largest, 1e-10 * 0.1);
      EXPECT_TRUE(error.trusted);
    }
  }
}

TEST(MeshNumber, IsZeroUnderUniformStress) {
  const Mat3<double> stretched = {{1.2, 0.1, 0, 0, 0.9, -0.1, 0.05, 0, 1.1}};
  // of a full box, and of a body that is cut by its grid
  Scene box = scene_on(make_box(7, 6, 5, 0.02), solid(1e5, 0.3));
  finish_scene(box);
  const Scene ball = free_ball();
  for (const Scene* scene : std::initializer_list<const Scene*>{&box, &ball}) {
    MeshNumber number(*scene, 0.03);
    number.begin(scene->grid.rest);
    const Array<double> x = affine(scene->grid, stretched, {0.1, 0, 0});
    EXPECT_LT(number.estimate(x, 0.03, at_nodes(scene->grid)).largest, 1e-10 * 0.1);
  }
}

/// A stiff ball is pressed and let go, again and again, in frames that its waves cross many times:
/// what the loose solve leaves must not carry d away.
TEST(MeshNumber, OfAFreePieceHasNoMomentum) {
  Scene scene = scene_on(test::ball_grid(0.1, 0.021), solid(1e8, 0.48));
  finish_scene(scene);
  MeshNumber number(scene, 0.03);
  number.begin(scene.grid.rest);
  double rms = 0;
  for (int frame = 1; frame <= 30; ++frame) {
    Array<double> x = scene.grid.rest;
    for (int64_t n = 0; n < x.rows(); ++n)  // flat below, while it lies
      x(n, 1) = std::max(x(n, 1), frame % 10 < 5 ? -0.09 : -0.2);
    rms = std::max(rms, number.estimate(x, 0.03, at_nodes(scene.grid)).rms);
    // the momentum of d, against the sum of its sizes
    Vec3 sum = {};
    double size = 0;
    for (int64_t n = 0; n < number.coarse().grid.node_count(); ++n) {
      const double* d = &number.difference()[size_t(3 * n)];
      sum = plus(sum, scaled({d[0], d[1], d[2]}, number.coarse().mass(n)));
      size += number.coarse().mass(n) * safe_norm({d[0], d[1], d[2]});
    }
    EXPECT_LE(safe_norm(sum), 1e-9 * size) << frame;
  }
  printf("stiff ball, pressed by 10 mm: at most %.2g m rms\n", rms);
  EXPECT_GT(rms, 1e-5);
  EXPECT_LT(rms, 0.02);
}

/// Turns with the body: the number of a motion that is turned as a whole is that of the motion.
TEST(MeshNumber, TurnsWithItsPiece) {
  const Scene scene = free_ball();
  const Embedding points = at_nodes(scene.grid);
  MeshNumber still(scene, 0.03), spun(scene, 0.03);
  still.begin(scene.grid.rest);
  spun.begin(scene.grid.rest);
  for (int frame = 1; frame <= 6; ++frame) {
    // a wave in y
    Array<double> x = scene.grid.rest, turned = x;
    const Mat3<double> R = rotation(0.9 * frame);
    for (int64_t n = 0; n < x.rows(); ++n) {
      x(n, 1) += 0.01 * std::sin(40 * x(n, 0) + frame);
      const Vec3 to = times(R, {x(n, 0), x(n, 1), x(n, 2)});
      std::copy_n(to.begin(), 3, turned.row(n));
    }
    const MeshError a = still.estimate(x, 0.03, points), b = spun.estimate(turned, 0.03, points);
    EXPECT_GT(a.rms, 1e-4);
    EXPECT_NEAR(b.rms, a.rms, 0.02 * a.rms) << frame;
  }
}

TEST(MeshNumber, HasTheSameBitsOnOneThread) {
  const Scene scene = test::clamped_beam(18, 9, 9, 0.01, solid(1e5, 0.4));
  const auto run = [&] {
    Array<double> x = scene.grid.rest;
    for (int64_t n = 0; n < x.rows(); ++n) x(n, 1) -= 0.5 * x(n, 0) * x(n, 0);
    MeshNumber number(scene, 0.03);
    number.begin(scene.grid.rest);
    number.estimate(x, 0.03, at_nodes(scene.grid));
    return number.estimate(x, 0.03, at_nodes(scene.grid)).rms;
  };
  const double all = run();
  ThreadLimit one(1);
  EXPECT_EQ(run(), all);
}

/// Positions of a body at rest under gravity: a step so long that inertia counts for nothing.
Array<double> equilibrium(const Scene& scene) {
  IncrementalPotential potential{PotentialTerms(scene)};
  const int64_t nodes = scene.grid.node_count();
  std::vector<double> u(size_t(3 * nodes)), motion(u.size());
  Preconditioner<double>* preconditioner = nullptr;
  std::optional<Preconditioner<double>> made;
  for (const double load : {0.25, 0.5, 0.75, 1.0}) {
    State state;
    state.x = state.v = Array<double>(nodes, 3);
    for (size_t k = 0; k < u.size(); ++k) {
      state.x.data()[k] = scene.grid.rest.data()[k] + u[k];
      motion[k] = scene.dt * scene.dt * load * scene.gravity[k % 3];
    }
    potential.begin_stage(state, {TimeScheme::kEuler, scene.dt, 1}, motion.data(), nullptr);
    if (!preconditioner) preconditioner = &made.emplace(potential, EncoderChoice{true, 5});
    NewtonSolver newton(potential);
    const double target = 1e-8 * reference_force(scene);
    newton.solve(u.data(), target, 60, 400, *preconditioner, [] { return false; });
  }
  Array<double> x = scene.grid.rest;
  for (size_t k = 0; k < u.size(); ++k) x.data()[k] += u[k];
  return x;
}

/// A body at rest at some h, and points in it.
struct Rest {
  Scene scene;
  Array<double> x, moved;
};

Rest at_rest(const VoxelGrid& grid, const Material& material, int axis, double limit,
             const Array<double>& points) {
  Rest rest{scene_on(grid, material), {}, Array<double>(points.rows(), 3)};
  test::pin_below(rest.scene, axis, limit + 1e-9);
  rest.scene.gravity = {0, -9.81, 0};
  rest.scene.dt = 100;
  finish_scene(rest.scene);
  rest.x = equilibrium(rest.scene);
  deform_asset(rest.scene.grid, embed(rest.scene.grid, points), rest.x, rest.moved);
  return rest;
}

double rms_difference(const Array<double>& a, const Array<double>& b) {
  double sum = 0;
  for (int64_t k = 0; k < a.size(); ++k) sum += std::pow(a.data()[k] - b.data()[k], 2);
  return std::sqrt(sum / double(a.rows()));
}

/// The number over the true error of a body at three h, against four times the finest.
void expect_ratios(const std::function<VoxelGrid(double h)>& body, const double (&edges)[3],
                   const Material& material, int axis, double limit) {
  const Array<double> points = body(edges[2]).rest;
  const Rest truth = at_rest(body(edges[2] / 4), material, axis, limit, points);
  for (const double h : edges) {
    const Rest rest = at_rest(body(h), material, axis, limit, points);
    MeshNumber number(rest.scene, 0);
    const MeshError error = number.estimate(rest.x, 0, embed(rest.scene.grid, points));
    const double ratio = error.rms / rms_difference(rest.moved, truth.moved);
    std::printf("h %.4f m: true %.3e m, number %.3e m, ratio %.2f\n", h,
                rms_difference(rest.moved, truth.moved), error.rms, ratio);
    EXPECT_GT(ratio, 0.33);
    EXPECT_LT(ratio, 4.5);
    EXPECT_TRUE(error.trusted);
  }
}

TEST(MeshNumber, EstimatesTheErrorOfACantilever) {
  expect_ratios(
      [](double h) {
        return make_box(int(std::lround(0.16 / h)), int(std::lround(0.04 / h)),
                        int(std::lround(0.04 / h)), h);
      },
      {0.02, 0.04 / 3, 0.01}, solid(1e5, 0.3), 0, 0);
}

TEST(MeshNumber, EstimatesTheErrorOfABallOnItsFoot) {
  expect_ratios([](double h) { return test::ball_grid(0.05, h); }, {0.02, 0.04 / 3, 0.01},
                solid(5e3, 0.4), 1, -0.04);
}

/// Frames of a bar that swings from rest, where its points are, and its mesh numbers.
struct Swing {
  std::vector<Array<double>> moved;
  std::vector<MeshError> numbers;
};

Swing swing(int across, int frames, const Array<double>& points) {
  const double h = 0.03 / across;
  Scene scene = scene_on(make_box(3 * across, across, across, h), solid(2e4, 0.4));
  test::pin_below(scene, 0, h / 2);
  scene.gravity = {0, -9.81, 0};
  scene.dt = 1.0 / 30;
  scene.scheme = TimeScheme::kAuto;
  finish_scene(scene);
  Solver solver(scene, {});
  MeshNumber number(scene, scene.dt);
  const Embedding embedding = embed(scene.grid, points);
  State state = initial_state(scene);
  number.begin(state.x);
  Swing result;
  while (int(result.moved.size()) < frames) {
    while (!solver.step(state).completes) {
    }
    result.moved.emplace_back(points.rows(), 3);
    deform_asset(scene.grid, embedding, state.x, result.moved.back());
    result.numbers.push_back(number.estimate(state.x, scene.dt, embedding));
  }
  return result;
}

TEST(MeshNumber, EstimatesTheErrorOfAMotion) {
  const Array<double> points = make_box(12, 4, 4, 0.0075).rest;
  constexpr int kFrames = 12;
  const Swing truth = swing(16, kFrames, points), coarse = swing(4, kFrames, points);
  double number = 0, error = 0;
  for (size_t k = 0; k < kFrames; ++k) {
    number += coarse.numbers[k].rms * coarse.numbers[k].rms;
    error += std::pow(rms_difference(coarse.moved[k], truth.moved[k]), 2);
    EXPECT_TRUE(coarse.numbers[k].trusted);
  }
  const double ratio = std::sqrt(number / error);
  std::printf("a swing: true %.3e m, ratio %.2f\n", std::sqrt(error / kFrames), ratio);
  EXPECT_GT(ratio, 1 / 3.0);
  EXPECT_LT(ratio, 3);
}

TEST(MeshNumber, SaysWhereVoxelsAreTooCoarse) {
  // a bar of two voxels that is folded by a right angle within one of them
  Scene scene = scene_on(make_box(8, 2, 2, 0.02), solid(1e5, 0.3));
  test::pin_below(scene, 0, 0.01);
  finish_scene(scene);
  Array<double> x = scene.grid.rest;
  for (int64_t n = 0; n < x.rows(); ++n) {
    const double along = x(n, 0) - 0.08, up = x(n, 1);
    if (along > 0) x(n, 0) = 0.08 + up, x(n, 1) = 0.04 + along;
  }
  MeshNumber number(scene, 0);
  EXPECT_FALSE(number.estimate(x, 0, at_nodes(scene.grid)).trusted);
}

}  // namespace
}  // namespace elastogen
