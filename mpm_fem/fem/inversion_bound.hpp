// SPDX-License-Identifier: Apache-2.0
// How far a step may go before it turns a point inside out.

#pragma once

#include "core/mat3.hpp"

namespace elastogen::fem {

/// A safe share, at most 1, of the straight path from F to `end`: 9/10 of the share at which det
/// first falls to a tenth of det F. It is 1 if det does not fall so far, or if det F is not
/// positive.
double share_before_inversion(const Mat3<double>& F, const Mat3<double>& end);

}  // namespace elastogen::fem
