// SPDX-License-Identifier: Apache-2.0
// A step of a body that yields, in as many parts as it needs: flow depends on the path of a step,
// and where Newton's method fails a shorter path may succeed.

#pragma once

#include "mpm_fem/integrators/implicit_fem.hpp"

namespace elastogen::fem {

/// Advances the state by dt in equal parts, at most 16, in which no collider goes farther than an
/// element's edge, and none that touches the body farther than a tenth of it; a part that does not
/// converge is undone and halved, up to four times. The last try is kept
/// even so: a draft. Colliders and prescribed motions are those at the ends of the parts; each part
/// commits the history of its materials.
///
/// The report has the summed work of the parts, their largest residual, floor and overlap, and the
/// energies of the last part. If a part has no finite result, or `stop` returns true between two
/// parts, the state stays as it was.
/// @throws Error as ImplicitFem::step.
FemStepReport step_in_parts(
    ImplicitFem& solver, FemState& state, const std::function<bool()>& stop = [] { return false; });

}  // namespace elastogen::fem
