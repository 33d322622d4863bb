// SPDX-License-Identifier: Apache-2.0
// The scenes of the benchmarks: a clamped beam and a porous ball, sized by their voxel count.

#pragma once

#include "core/scene.hpp"

namespace elastogen::bench {

struct SceneOptions {
  double voxels = 1e4;  ///< wanted count; the grid comes within a few per cent
  double courant = 10;  ///< (dt/h) sqrt(E/rho)
  double poisson = 0.3;
  Law law = Law::kNeoHookean;
};

/// 4n x n x n voxels under gravity, clamped at x = 0; 1 m long, dt = 1/60 s.
Scene cantilever(const SceneOptions& options);

/// A ball of diameter 1 m with a lattice of pores, about 60 % full, true fills at its borders; the
/// lowest 12 % are pinned.
Scene porous_ball(const SceneOptions& options);

}  // namespace elastogen::bench
