// SPDX-License-Identifier: Apache-2.0
// How densely a cloud samples its surface, and which of its points lie apart from the others.

#pragma once

#include "core/base.hpp"

#include <cstdint>
#include <vector>

namespace elastogen {

/// Median over the points of the distance to the eighth nearest other point (the farthest where
/// there are fewer), in the unit of the points; of large clouds over 20,000 of them. Points at one
/// place count once.
/// @return 0 if all points lie in one place.
double point_spacing(const std::vector<Vec3>& points);

/// One point for each cell of a lattice of that edge: the mean of those in the cell. Ordered by
/// cell, the same bits at any number of threads.
std::vector<Vec3> thinned(const std::vector<Vec3>& points, double edge);

/// Points of clusters that hold at least `share` of them all. Points whose cells of a lattice of
/// edge `reach` touch are in one cluster, so that points closer than `reach` always are.
/// @return 1 for each point that is kept; all are where no cluster is large enough.
std::vector<uint8_t> large_clusters(const std::vector<Vec3>& points, double reach, double share);

}  // namespace elastogen
