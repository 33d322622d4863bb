// SPDX-License-Identifier: Apache-2.0
// What dependent nodes (core/dependent_nodes.hpp) add to the diagonal at their parent nodes. The
// preconditioner leaves them out like pinned nodes, but its smoother must not take parent nodes for
// softer than they are.

#pragma once

#include "core/scene.hpp"

#include <vector>

namespace elastogen {

/// max(0, diag(C^T A C) - diag A) at parent nodes [N/m], (3 nodes), for the three scalar operators of
/// the multigrid with u = C u_free; empty where no node is dependent.
/// @param inertia  a0 / dt^2 [1/s^2].
std::vector<double> dependent_diagonal(const Scene& scene, double inertia);

}  // namespace elastogen
