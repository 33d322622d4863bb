// SPDX-License-Identifier: Apache-2.0
// Moving scenes as finite elements, small ones of the network's, and runs of them frame by frame.

#pragma once

#include "mpm_fem/fem/voxel_element.hpp"
#include "mpm_fem/integrators/implicit_fem.hpp"
#include "mpm_fem/integrators/stage_fem.hpp"
#include "tests/network/step/motion_scenes.hpp"

namespace elastogen::test {

/// A ball of 4 voxels across, pushed down a floor by its own fall from a height.
inline MovingScene small_ball(double young, double height) {
  const double R = 0.2, h = 0.1, speed = std::sqrt(2 * 9.81 * height);
  MovingScene m{scene_on(ball_grid(R, h), solid(young, 0.4)), {}};
  m.scene.surface = sphere_points(m.scene.grid, R, 200);
  m.scene.colliders = {half_space({0, 1, 0}, -R - 1.3 * kFrame * speed, 0.5)};
  m.scene.gravity = {0, -9.81, 0};
  finish_scene(m.scene);
  m.start = initial_state(m.scene, {.velocity = {0, -speed, 0}});
  return m;
}

/// A block of 3 x 2 x 3 voxels on a slope, which begins to carry its weight.
inline MovingScene small_block(double angle) {
  MovingScene m{scene_on(make_box(3, 2, 3, 0.08), solid(1e6, 0.4)), {}};
  m.scene.surface = face_points(m.scene.grid);
  m.scene.colliders = {half_space({0, 1, 0}, 0, 0.5)};
  m.scene.gravity = {9.81 * std::sin(angle), -9.81 * std::cos(angle), 0};
  finish_scene(m.scene);
  m.start = initial_state(m.scene);
  return m;
}

/// A block of 2 x 4 x 2 voxels, pinned at an edge, which swings from an angle.
inline MovingScene small_pendulum(double angle) {
  MovingScene m{scene_on(make_box(2, 4, 2, 0.1), solid(young_of_frame(25, 0.1), 0.4)), {}};
  for (int64_t n = 0; n < m.scene.grid.node_count(); ++n)
    m.scene.pinned(n) = m.scene.grid.node_coord(n, 1) == 4 && m.scene.grid.node_coord(n, 0) == 0;
  m.scene.gravity = {9.81 * std::sin(angle), -9.81 * std::cos(angle), 0};
  finish_scene(m.scene);
  m.start = initial_state(m.scene);
  return m;
}

/// The voxel element with the network's masses and contact points: the same potential; or another one.
inline fem::FemScene as_fem(const Scene& scene, fem::Element element = fem::Element::kVoxel) {
  fem::FemScene result;
  result.mesh = fem::voxel_mesh(scene, element);
  result.materials = scene.materials;
  result.mass = scene.mass;
  result.gravity = scene.gravity;
  result.dt = scene.dt;
  result.colliders = scene.colliders;
  if (!scene.colliders.empty()) result.contact = fem::voxel_contact(scene);
  result.fixed = Array<uint8_t>(scene.pinned.rows(), 3);
  for (int64_t n = 0; n < scene.pinned.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      result.fixed(n, d) =
          scene.pinned(n) == kPinnedNode || (!scene.fixed.empty() && scene.fixed(n, d) >= 0);
  result.dependent = scene.dependent;
  return result;
}

inline fem::FemState as_fem(const fem::FemScene& scene, const State& state) {
  fem::FemState result = fem::rest_state(scene);
  for (int64_t k = 0; k < result.u.size(); ++k)
    result.u.data()[k] = state.x.data()[k] - scene.mesh.rest.data()[k];
  result.v = state.v;
  return result;
}

/// Positions and velocities of a state.
inline State as_positions(const fem::FemScene& scene, const fem::FemState& state) {
  State result;
  result.x = scene.mesh.rest;
  for (int64_t k = 0; k < result.x.size(); ++k) result.x.data()[k] += state.u.data()[k];
  result.v = state.v;
  result.time = state.time;
  return result;
}

inline fem::StageOptions stage_options(double tolerance) {
  return {.solve = {.tolerance = tolerance, .as_positions = true},
          .follows_time_error = tolerance == 1e-3};
}

/// play() by finite elements, from a state that is left at the end.
inline std::vector<MotionFrame> play(fem::FemScene scene, fem::FemState& state, fem::Scheme scheme,
                                     int frames, int parts = 1, double tolerance = 1e-3) {
  scene.scheme = scheme;
  scene.dt = kFrame / parts;
  fem::StageFem solver(scene, stage_options(tolerance));
  // frame by frame, each of as many steps as it takes
  std::vector<MotionFrame> result;
  for (int frame = 0; frame < frames; ++frame) {
    MotionFrame& f = result.emplace_back();
    for (int part = 0; part < parts;) {
      const fem::FemStepReport r = solver.step(state);
      EXPECT_TRUE(r.finite && (r.converged || r.stop == fem::NewtonStop::kRoundOff))
          << "frame " << frame << ": " << r.residual << ' ' << stop_name(r.stop);
      if (!r.finite) return result;
      ++f.steps;
      f.solves += r.solves;
      f.outer += r.outer;
      f.estimate += r.time_error;
      const EnergyParts& e = r.energy;
      f.kinetic = e.kinetic;
      f.energy = e.kinetic + e.elastic + e.hourglass + e.gravity + e.contact;
      part += r.completes;
    }
    f.state = as_positions(scene, state);
  }
  return result;
}

inline std::vector<MotionFrame> play(const MovingScene& from, fem::Scheme scheme, int frames,
                                     int parts = 1, double tolerance = 1e-3) {
  const fem::FemScene scene = as_fem(from.scene);
  fem::FemState state = as_fem(scene, from.start);
  return play(scene, state, scheme, frames, parts, tolerance);
}

}  // namespace elastogen::test
