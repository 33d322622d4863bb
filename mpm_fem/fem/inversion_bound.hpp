// SPDX-License-Identifier: Apache-2.0
// How far a step may go before it turns a point inside out.

#pragma once

#include "core/mat3.hpp"

namespace elastogen::fem {

/// Share, at most 1, of the way from F to `end`: 9/10 of that to the first place where det falls to
/// a tenth of det F, where there is one before the end; 1 also where det F is not positive.
double share_before_inversion(const Mat3<double>& F, const Mat3<double>& end);

}  // namespace elastogen::fem
