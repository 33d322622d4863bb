// SPDX-License-Identifier: Apache-2.0
// The nearest positive semi-definite matrix to that of an element.

#pragma once

namespace elastogen::fem {

/// Sets the negative eigenvalues of a symmetric K to 0, row-major (size, size) with size at most
/// kMaxDofs; K is unchanged to the bit where there are none.
void clamp_eigenvalues(int size, double* K);

}  // namespace elastogen::fem
