// SPDX-License-Identifier: Apache-2.0
// The moving scenes of the network as finite elements, and runs of them frame by frame.

#pragma once

#include "mpm_fem/fem/voxel_element.hpp"
#include "mpm_fem/integrators/stage_fem.hpp"
#include "tests/network/step/motion_scenes.hpp"

namespace elastogen::test {

/// The voxel element with the network's masses and contact points: the same potential.
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
    std::fill_n(result.fixed.row(n), 3, scene.pinned(n));
  return result;
}

inline fem::FemState as_fem(const fem::FemScene& scene, const State& state) {
  fem::FemState result = fem::rest_state(scene);
  for (int64_t k = 0; k < result.u.size(); ++k)
    result.u.data()[k] = state.x.data()[k] - scene.mesh.rest.data()[k];
  result.v = state.v;
  return result;
}

/// A state as positions.
inline State as_positions(const fem::FemScene& scene, const fem::FemState& state) {
  State result;
  result.x = scene.mesh.rest;
  for (int64_t k = 0; k < result.x.size(); ++k) result.x.data()[k] += state.u.data()[k];
  result.v = state.v;
  result.time = state.time;
  return result;
}

/// play() by finite elements.
inline std::vector<MotionFrame> play_fem(fem::FemScene scene, const State& start,
                                         fem::Scheme scheme, int frames, int parts = 1,
                                         fem::StageOptions options = {
                                             .solve = {.tolerance = 1e-3, .as_positions = true}}) {
  scene.scheme = scheme;
  scene.dt = kFrame / parts;
  fem::StageFem solver(scene, options);
  fem::FemState state = as_fem(scene, start);
  std::vector<MotionFrame> result;
  for (int frame = 0; frame < frames; ++frame) {
    MotionFrame& f = result.emplace_back();
    for (int part = 0; part < parts;) {
      const fem::FemStepReport r = solver.step(state);
      EXPECT_TRUE(r.finite && r.converged)
          << "frame " << frame << ": " << r.residual << ' ' << stop_name(r.stop);
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
    f.state = as_positions(scene, state);
  }
  return result;
}

inline std::vector<MotionFrame> play_fem(const MovingScene& from, fem::Scheme scheme, int frames,
                                         int parts = 1,
                                         fem::StageOptions options = {
                                             .solve = {.tolerance = 1e-3, .as_positions = true}}) {
  return play_fem(as_fem(from.scene), from.start, scheme, frames, parts, options);
}

}  // namespace elastogen::test
