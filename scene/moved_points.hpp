// SPDX-License-Identifier: Apache-2.0
// Points of the surface that go along with a move behind its border. They are no part of the body that
// is stepped, so that they meet no collider there, and must not run into one.

#pragma once

#include "scene/set_up.hpp"

#include <string>

namespace elastogen {

/// Adds those of points behind borders that go with holders that move to Setup::moved_points.
void note_moved(const std::vector<HeldPoint>& behind, Setup& setup);
/// The same, and takes them from the points that meet colliders.
void drop_moved(const std::vector<HeldPoint>& behind, Setup& setup);

/// Names a collider that such a point lies in at a time [s], below its layer, and the move; empty: there
/// is none.
std::string collider_in_the_way(const Setup& setup, double time);

}  // namespace elastogen
