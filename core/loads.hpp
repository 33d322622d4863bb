// SPDX-License-Identifier: Apache-2.0
// Forces from outside on the nodes of a scene, beside gravity: dead loads, forces that change with time,
// and wind. Of wind each point of the surface with the area vector A at rest feels
//
//     f = c rho/2 |w . a| (w . a) a / |a|^2,     a = cof(F) A,     w = W(t) - v
//
// (F of its voxel, v its velocity): the pressure of a stream that is stopped, c = 1, on surfaces with two
// sides, half of it on each side of closed bodies; a plate has the drag coefficient 1, a ball 1/2. All
// are those of the end of a step or stage (core/wind_load.hpp).

#pragma once

#include "core/array.hpp"
#include "core/path.hpp"

#include <vector>

namespace elastogen {

struct Scene;
struct VoxelGrid;

/// A force that acts on each node by a share.
struct TimedForce {
  Array<double> share;  ///< of each node, (nodes, 1)
  Path force;           ///< F(t) [N]
};

struct Wind {
  Path velocity;         ///< W(t) [m/s]; empty: there is none
  double density = 1.2;  ///< of the air [kg/m^3]
  double share = 0.5;    ///< c
  // the surface
  Array<int32_t> voxel;   ///< (points, 1)
  Array<double> weights;  ///< trilinear weight of each corner, (points, 8)
  Array<double> area;     ///< A [m^2], (points, 3)

  bool blows() const { return !velocity.keys.empty(); }
};

/// Whether something of it acts.
bool has_loads(const Scene& scene);
/// Whether what acts changes.
bool has_changing_loads(const Scene& scene);

}  // namespace elastogen
