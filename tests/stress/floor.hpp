// SPDX-License-Identifier: Apache-2.0
// The floor of the stress cases: how a scene gets one, how deep its points lie, and the contact
// equations of docs/formats.md for it.

#pragma once

#include "core/scene.hpp"

#include <vector>

namespace elastogen::stress {

/// A floor of normal +y at that height [m], with contact points on every free voxel face.
void put_floor(Scene& scene, double height, double friction = 0.5);

/// Lowest place of a surface point relative to the floor, 1e300 without one [m].
double lowest_point(const Scene& scene, const Array<double>& x);

/// Energy of the barrier [J], without friction; infinite on or behind the plane.
double barrier_energy(const Scene& scene, const Array<double>& x);

/// Adds the derivative of the contact energy of the step from x_start to x [N], (nodes, 3).
void add_contact_force(const Scene& scene, const Array<double>& x_start, const Array<double>& x,
                       std::vector<double>& force);

}  // namespace elastogen::stress
