// SPDX-License-Identifier: Apache-2.0
// What holds add to the diagonal. The preconditioner leaves dependent nodes (core/dependent_nodes.hpp)
// out like pinned nodes, but its smoother must not take their parent nodes for softer than they are.
// It does not know fixed components (Scene::fixed) as such: they are stiff in it, on all levels.

#pragma once

#include "core/scene.hpp"

#include <vector>

namespace elastogen {

inline constexpr double kHoldStiffness = 10;

/// max(0, diag(C^T A C) - diag A) at parent nodes [N/m], (3 nodes), for the three scalar operators of
/// the multigrid with u = C u_free, and kHoldStiffness diag A at fixed components; empty where there
/// are neither.
/// @param inertia  a0 / dt^2 [1/s^2].
std::vector<double> held_diagonal(const Scene& scene, double inertia);

}  // namespace elastogen
