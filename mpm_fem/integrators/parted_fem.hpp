// SPDX-License-Identifier: Apache-2.0
// A step of a body that yields, in as many parts as it takes: flow depends on the way that a step
// takes, and where Newton's method fails a shorter way may do.

#pragma once

#include "mpm_fem/integrators/implicit_fem.hpp"

namespace elastogen::fem {

/// Advances the state by dt in equal parts in which no collider goes farther than an element's
/// edge; a part that does not converge is taken back and halved, up to four times. What the last
/// try leaves is kept: a draft. Colliders and moves are where they are at the ends of the parts;
/// each part commits what its materials remember.
///
/// Of the parts the report has the sum of the work, the largest residual, floor and overlap, and the
/// energies of the last. If a part has no finite result, or `stop` says so between two, the state
/// stays as it was.
/// @throws Error as ImplicitFem::step.
FemStepReport step_in_parts(
    ImplicitFem& solver, FemState& state, const std::function<bool()>& stop = [] { return false; });

}  // namespace elastogen::fem
