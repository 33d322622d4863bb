// SPDX-License-Identifier: Apache-2.0
// Why a step could not be solved, in numbers.

#pragma once

#include "core/report.hpp"

#include <string>

namespace elastogen {

/// Tells of a step that is not converged:
///
///  - its residual, the one that was allowed, and its iterations,
///  - the free node with the largest force f that is out of balance, its place in the asset at rest,
///    and f / (E h^2), the share by which f would stretch a voxel,
///  - the smallest det F, where that is below 0.1,
///  - rho g L / E, the share by which the body, L long, shortens under its own weight.
///
/// @param gradient  grad Phi at the end of the step [N], (nodes, 3).
std::string why_draft(const Scene& scene, const StepReport& step, Span<const double> gradient);

}  // namespace elastogen
