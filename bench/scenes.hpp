// SPDX-License-Identifier: Apache-2.0
// The scenes of the benchmarks, sized by their number of voxels: a clamped beam, a porous ball, a
// free spinning bar, the demo character.

#pragma once

#include "core/scene.hpp"
#include "core/state.hpp"

#include <string>

namespace elastogen::bench {

struct SceneOptions {
  double voxels = 1e4;  ///< wanted number; the grid has it within a few per cent
  double courant = 10;  ///< (dt/h) sqrt(E/rho)
  double poisson = 0.3;
  Law law = Law::kNeoHookean;
  Hourglass hourglass = Hourglass::kFull;
};

/// A scene and its motion at the start.
struct BenchScene {
  Scene scene;
  StartMotion motion;
};

/// 4n x n x n voxels under gravity, clamped at x = 0; 1 m long, dt = 1/60 s.
Scene cantilever(const SceneOptions& options);

/// A ball of diameter 1 m with a lattice of pores, about 60 % full, with exact fills at its
/// borders. Its lowest 12 % are pinned.
Scene porous_ball(const SceneOptions& options);

/// 4n x n x n voxels, 1 m long, free and without gravity, spinning by 0.4 rad in a step.
BenchScene spinning_bar(const SceneOptions& options);

/// The character of `elastogen demo`, about 0.5 m tall, held by a hand under gravity.
Scene character(const SceneOptions& options);

/// The scene with that name: beam, ball, bar, character. @throws Error naming them.
BenchScene bench_scene(const std::string& name, const SceneOptions& options);

}  // namespace elastogen::bench
