// SPDX-License-Identifier: Apache-2.0
// The equations of a time step as docs/formats.md states them, in separate plain float64 loops, by
// which a stress run is judged. They share no arithmetic with the solver.

#pragma once

#include "core/scene.hpp"
#include "core/state.hpp"

#include <vector>

namespace elastogen::stress {

/// Results of the equations for one step.
struct Balance {
  double residual = 0;       ///< of "The residual, exactly" [-]
  double energy_before = 0;  ///< kinetic, elastic, hourglass and barrier at the start [J]
  double energy = 0;         ///< these energies at the end [J]
  double gravity_work = 0;   ///< of gravity over the step [J]
  double residual_work = 0;  ///< of the forces that the solver left unbalanced [J]
  /// By how much the energy of the voxels lies above its tangent at the end of the step [J]. Where
  /// it is convex this is not negative; a negative amount is energy that implicit Euler may gain.
  double convexity = 0;
  std::vector<double> internal;  ///< derivative of elastic and hourglass energy [N], (nodes, 3)
};

/// The balance of the step from `before` to `after` with the time scheme that was used.
Balance balance(const Scene& scene, const State& before, const State& after, TimeScheme scheme);

/// det F of each voxel, mean gradient over its fill.
std::vector<double> voxel_jacobians(const Scene& scene, const Array<double>& x);

/// Corners of voxels at which det F is not positive.
int64_t inverted_corners(const Scene& scene, const Array<double>& x);

/// Largest distance of a node of x from that of y after the best rigid motion of y [m].
double shape_distance(const Array<double>& x, const Array<double>& y);

}  // namespace elastogen::stress
