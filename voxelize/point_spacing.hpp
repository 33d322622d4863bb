// SPDX-License-Identifier: Apache-2.0
// The density at which a cloud samples its surface, and points that lie apart from the others.

#pragma once

#include "core/base.hpp"

#include <cstdint>
#include <vector>

namespace elastogen {

/// Median distance from a point to its eighth nearest neighbour (or the farthest if there are
/// fewer), in the unit of the points; for large clouds over 20,000 of them. Points at one place
/// count once.
/// @return 0 if all points lie in one place.
double point_spacing(const std::vector<Vec3>& points);

/// One point for each cell of a lattice with this edge: the mean of the cell's points. Sorted by
/// cell; any number of threads gives the same bits.
std::vector<Vec3> thinned(const std::vector<Vec3>& points, double edge);

/// Marks points in clusters that have at least `share` of all points. Points whose cells of a
/// lattice of edge `reach` touch belong to one cluster, so points closer than `reach` always do.
/// @return 1 for each point that is kept; all are kept if no cluster is large enough.
std::vector<uint8_t> large_clusters(const std::vector<Vec3>& points, double reach, double share);

}  // namespace elastogen
