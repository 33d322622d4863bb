// SPDX-License-Identifier: Apache-2.0
// Constants that solvers, scenes and reports share.

#pragma once

namespace elastogen {

/// Default gravity, g_ref of residuals and gravity of a body's free-fall speed [m/s^2].
inline constexpr double kReferenceGravity = 9.81;

}  // namespace elastogen
