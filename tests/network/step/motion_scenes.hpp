// SPDX-License-Identifier: Apache-2.0
// Scenes whose motion is known in closed form or by a fine run, and runs frame by frame.

#pragma once

#include "network/solver.hpp"
#include "tests/network/scenes.hpp"

#include <gtest/gtest.h>

#include <numbers>

namespace elastogen::test {

inline constexpr double kFrame = 1.0 / 30;

/// A scene and the state that it starts with.
struct MovingScene {
  Scene scene;
  State start;
};

/// What a run has at the end of a frame.
struct MotionFrame {
  State state;
  double energy = 0;          ///< kinetic, of voxels, gravity and contact [J]
  double kinetic = 0;         ///< [J]
  double estimate = 0;        ///< sum of the estimates of its steps [m]
  int steps = 0, solves = 0;  ///< those of rejected steps included
  int outer = 0, inner = 0;   ///< iterations
};

/// Runs a scene at dt = 1/30 s divided by `parts`; `auto` has no parts.
inline std::vector<MotionFrame> play(const MovingScene& from, TimeScheme scheme, int frames,
                                     int parts = 1, SolverOptions options = {}) {
  Scene scene = from.scene;
  scene.scheme = scheme;
  scene.dt = kFrame / parts;
  finish_scene(scene);
  Solver solver(scene, options);
  solver.begin(from.start);
  // frame by frame, each of as many steps as it takes
  std::vector<MotionFrame> result;
  for (int frame = 0; frame < frames; ++frame) {
    MotionFrame& f = result.emplace_back();
    for (int part = 0; part < parts;) {
      const StepReport r = solver.advance();
      EXPECT_TRUE(r.finite && r.converged) << "frame " << frame << ": " << r.residual;
      if (!r.finite) return result;
      ++f.steps;
      f.solves += r.solves;
      f.outer += r.outer;
      f.inner += r.inner;
      f.estimate += r.time_error;
      const EnergyParts& e = r.energy;
      f.kinetic = e.kinetic;
      f.energy = e.kinetic + e.elastic + e.hourglass + e.gravity + e.contact;
      part += r.completes;
    }
    solver.read(f.state);
  }
  return result;
}

inline double solves_a_frame(const std::vector<MotionFrame>& run) {
  double sum = 0;
  for (const MotionFrame& f : run) sum += f.solves;
  return sum / double(run.size());
}

/// Centre of mass and angular momentum about it.
struct MeanMotion {
  Vec3 centre = {}, velocity = {}, spin = {};
  double mass = 0;
};

inline MeanMotion mean_motion(const Scene& scene, const State& state) {
  MeanMotion m;
  const auto row = [](const Array<double>& a, int64_t n) -> Vec3 {
    return {a(n, 0), a(n, 1), a(n, 2)};
  };
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    m.mass += scene.mass(n);
    for (size_t d = 0; d < 3; ++d) {
      m.centre[d] += scene.mass(n) * state.x(n, int64_t(d));
      m.velocity[d] += scene.mass(n) * state.v(n, int64_t(d));
    }
  }
  m.centre = elastogen::scaled(m.centre, 1 / m.mass);
  m.velocity = elastogen::scaled(m.velocity, 1 / m.mass);
  for (int64_t n = 0; n < scene.grid.node_count(); ++n)
    m.spin = plus(m.spin, elastogen::scaled(cross(minus(row(state.x, n), m.centre),
                                                  minus(row(state.v, n), m.velocity)),
                                            scene.mass(n)));
  return m;
}

/// rms over the nodes, weighted with mass, of x - y.
inline double rms_distance(const Scene& scene, const Array<double>& x, const Array<double>& y) {
  double sum = 0, mass = 0;
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
    mass += scene.mass(n);
    for (int d = 0; d < 3; ++d) sum += scene.mass(n) * (x(n, d) - y(n, d)) * (x(n, d) - y(n, d));
  }
  return std::sqrt(sum / mass);
}

/// Young's modulus at which the Courant number of a frame is C.
inline double young_of_frame(double C, double h) {
  return young_of_courant(C, h, kFrame);
}

inline MovingScene spinning_ball(double C, double rate) {
  const double h = 0.05;
  MovingScene m{scene_on(ball_grid(0.2, h), solid(young_of_frame(C, h), 0.4)), {}};
  finish_scene(m.scene);
  m.start = initial_state(m.scene, {.spin = {0, 0, rate}});
  return m;
}

/// Spins about the axis of its middle moment of inertia, a little off.
inline MovingScene tumbling_box(double C, double rate) {
  const double h = 0.05;
  MovingScene m{scene_on(make_box(3, 5, 8, h), solid(young_of_frame(C, h), 0.4)), {}};
  finish_scene(m.scene);
  m.start = initial_state(m.scene, {.spin = {0.02 * rate, rate, 0.01 * rate}});
  return m;
}

/// A block pinned at one of its edges, which swings from an angle.
inline MovingScene pendulum(double angle) {
  const double h = 0.05;
  MovingScene m{scene_on(make_box(4, 8, 3, h), solid(young_of_frame(50, h), 0.4)), {}};
  for (int64_t n = 0; n < m.scene.grid.node_count(); ++n)
    m.scene.pinned(n) = m.scene.grid.node_coord(n, 1) == 8 && m.scene.grid.node_coord(n, 0) == 0;
  m.scene.gravity = {9.81 * std::sin(angle), -9.81 * std::cos(angle), 0};
  finish_scene(m.scene);
  m.start = initial_state(m.scene);
  return m;
}

inline MovingScene released_cantilever(double young) {
  MovingScene m{clamped_beam(16, 4, 4, 0.05, solid(young, 0.4)), {}};
  m.start = initial_state(m.scene);
  return m;
}

/// A bar that vibrates along its length in its first mode, with a period of so many frames. The
/// amplitude is a share of its length.
inline MovingScene vibrating_bar(double frames, double amplitude) {
  const double h = 0.05, L = 16 * h, c = 2 * L / (frames * kFrame);
  MovingScene m{scene_on(make_box(16, 3, 3, h), solid(1000 * c * c, 0)), {}};
  finish_scene(m.scene);
  m.start = initial_state(m.scene);
  const double omega = 2 * std::numbers::pi / (frames * kFrame);
  for (int64_t n = 0; n < m.start.x.rows(); ++n)
    m.start.v(n, 0) =
        amplitude * L * omega * std::cos(std::numbers::pi * m.scene.grid.rest(n, 0) / L);
  return m;
}

/// Points on a sphere, carried by the voxels they lie in or the nearest ones.
inline SurfacePoints sphere_points(const VoxelGrid& grid, double R, int count) {
  SurfacePoints s;
  s.voxel = Array<int32_t>(count);
  s.weights = Array<double>(count, 8);
  s.area = Array<double>(count);
  s.position = Array<double>(count, 3);
  // a spiral, and for each point of it the nearest voxel with the weights there
  for (int p = 0; p < count; ++p) {
    const double z = 1 - (2 * p + 1.0) / count, turn = p * std::numbers::pi * (3 - std::sqrt(5.0));
    const double ring = std::sqrt(1 - z * z);
    const Vec3 at = {R * ring * std::cos(turn), R * z, R * ring * std::sin(turn)};
    double nearest = 1e300;
    for (int64_t v = 0; v < grid.voxel_count(); ++v) {
      double away = 0;
      for (int d = 0; d < 3; ++d)
        away += std::pow(at[size_t(d)] - grid.h * (grid.voxel_coord(v, d) + 0.5), 2);
      if (away < nearest) nearest = away, s.voxel(p) = int32_t(v);
    }
    double t[3];
    for (int d = 0; d < 3; ++d) {
      t[d] = at[size_t(d)] / grid.h - grid.voxel_coord(s.voxel(p), d);
      s.position(p, d) = at[size_t(d)];
    }
    for (int c = 0; c < 8; ++c)
      s.weights(p, c) =
          (c & 1 ? t[0] : 1 - t[0]) * (c & 2 ? t[1] : 1 - t[1]) * (c & 4 ? t[2] : 1 - t[2]);
    s.area(p) = 4 * std::numbers::pi * R * R / count;
  }
  return s;
}

/// A ball that falls on a floor from a height, from a frame before it meets it on.
inline MovingScene dropped_ball(double young, double height, double friction = 0.5) {
  const double R = 0.2, h = 0.05, speed = std::sqrt(2 * 9.81 * height);
  MovingScene m{scene_on(ball_grid(R, h), solid(young, 0.4)), {}};
  m.scene.surface = sphere_points(m.scene.grid, R, 600);
  m.scene.colliders = {half_space({0, 1, 0}, -R - 1.3 * kFrame * speed, friction)};
  m.scene.gravity = {0, -9.81, 0};
  finish_scene(m.scene);
  m.start = initial_state(m.scene, {.velocity = {0, -speed, 0}});
  return m;
}

/// A block above a floor, or on it.
inline MovingScene block_on_floor(double young, double height) {
  const double h = 0.05;
  MovingScene m{scene_on(make_box(5, 4, 6, h), solid(young, 0.4)), {}};
  m.scene.surface = face_points(m.scene.grid);
  m.scene.colliders = {half_space({0, 1, 0}, -height, 0.5)};
  m.scene.gravity = {0, -9.81, 0};
  finish_scene(m.scene);
  m.start = initial_state(m.scene);
  return m;
}

/// A block that lies on a slope, its weight carried: gravity is turned by the angle.
inline MovingScene block_on_slope(double young, double angle, double friction) {
  MovingScene m = block_on_floor(young, 0);
  m.scene.colliders[0].friction = friction;
  m.scene.gravity = {9.81 * std::sin(angle), -9.81 * std::cos(angle), 0};
  finish_scene(m.scene);
  m.start = initial_state(m.scene);
  return m;
}

/// A ball on a slope.
inline MovingScene ball_on_slope(double young, double angle, double friction) {
  MovingScene m = dropped_ball(young, 0, friction);
  m.scene.gravity = {9.81 * std::sin(angle), -9.81 * std::cos(angle), 0};
  finish_scene(m.scene);
  m.start = initial_state(m.scene);
  return m;
}

}  // namespace elastogen::test
