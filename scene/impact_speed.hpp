// SPDX-License-Identifier: Apache-2.0
// How fast a body may meet a collider, which its contact layer has to stand.

#pragma once

#include "core/scene.hpp"
#include "core/state.hpp"

namespace elastogen {

/// A bound on the speed [m/s] at which the body meets a collider: that of its start, its spin and
/// the colliders' paths, and what gravity adds on the way down to the farthest collider,
///
///     v^2 = (|v0| + |w| r + |v_collider|)^2 + 2 |g| d.
///
/// Below a plane that is not level d counts as much as gravity acts along its normal. Speeds of pins
/// that move are not in it. 0 without colliders.
/// @param scene  with surface points and colliders.
double impact_speed(const Scene& scene, const StartMotion& motion);

}  // namespace elastogen
