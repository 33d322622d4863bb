// SPDX-License-Identifier: Apache-2.0
// The threads of the BLAS that SuiteSparse calls.

#pragma once

namespace elastogen::fem {

/// Holds OpenBLAS, if that is the BLAS in use, at one thread: the bits of its sums depend on the
/// number of threads. The reference BLAS has one; SuiteSparse's own loops do not sum across
/// threads.
void hold_blas_threads();

}  // namespace elastogen::fem
