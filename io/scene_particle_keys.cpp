// SPDX-License-Identifier: Apache-2.0
#include "io/scene_particle_keys.hpp"

namespace elastogen {
namespace {

using T = SceneType;
using Q = Quantity;
using Keys = std::vector<SceneKey>;

const SceneRange kAboveNone = {.least = 0, .above = true};
const SceneRange kShare = {.least = 0, .most = 1};

SceneRange count_to(double most) {
  return {.least = 1, .most = most};
}

/// Keys of the transfer between grid and particles.
Keys transfer_keys() {
  return {
      {"particles",
       "transfer",
       T::kText,
       "apic",
       "--transfer",
       "from the grid: the affine field around a particle, the same with what the grid smoothed "
       "away "
       "given back, its rigid part, or changes",
       Q::kNumber,
       {},
       {"apic", "apic-blend", "rpic", "flip"}},
      {"particles", "blend_time", T::kNumber, "0.01", "--blend-time",
       "apic-blend: time in which the grid smooths velocities away", Q::kTime, kAboveNone},
      {"particles", "flip", T::kNumber, "0.99", "--flip",
       "flip: share of the particles' own velocity", Q::kNumber, kShare},
  };
}

}  // namespace

Keys shape_keys() {
  return {
      {"shape",
       "kind",
       T::kText,
       "",
       "",
       "needed; a rectangle and a disk lie in the plane z = 0, a metre thick",
       Q::kNumber,
       {},
       {"box", "sphere", "rectangle", "disk"}},
      {"shape", "lower", T::kVector, "", "", "box and rectangle: the lower corner", Q::kLength},
      {"shape", "upper", T::kVector, "", "", "box and rectangle: the upper corner", Q::kLength},
      {"shape", "centre", T::kVector, "", "", "sphere and disk", Q::kLength},
      {"shape", "radius", T::kNumber, "", "", "sphere and disk", Q::kLength, kAboveNone},
  };
}

Keys particle_keys() {
  Keys keys = {
      // time steps
      {"particles",
       "integrator",
       T::kText,
       "implicit",
       "--integrator",
       "implicit Euler, explicit steps, or implicit Euler by minima with the plastic part frozen: "
       "until they solve it, or as PlasticityNet has them",
       Q::kNumber,
       {},
       {"implicit", "explicit", "frozen-fixed-point", "pn-fixed-point"}},
      {"particles",
       "dt",
       T::kNumber,
       "auto",
       "--dt",
       "from one transfer between particles and grid to the next; auto: by their speed, or that of "
       "waves",
       Q::kTime,
       kAboveNone,
       {"auto"}},
      {"particles", "substeps", T::kWhole, "1", "--particle-substeps",
       "explicit steps from one transfer to the next, on nodes that stay", Q::kNumber,
       count_to(1e6)},
      {"particles", "passes", T::kWhole, "3", "--passes",
       "pn-fixed-point: minima of a step, the plastic part frozen anew before each", Q::kNumber,
       count_to(1000)},
      // where particles stand at the start
      {"particles", "per_edge", T::kWhole, "2", "--per-edge",
       "particles of a full voxel along an axis", Q::kNumber, count_to(8)},
      {"particles", "jitter", T::kNumber, "1", "--jitter",
       "share of its part of the voxel in which a particle stands at random; 0: in the middle",
       Q::kNumber, kShare},
  };
  for (SceneKey& key : transfer_keys()) keys.push_back(std::move(key));
  return keys;
}

}  // namespace elastogen
