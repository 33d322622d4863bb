// SPDX-License-Identifier: Apache-2.0
// Orthonormal bases of many small square matrices at once; the formulas are in
// orthonormal_basis_impl.hpp. Libraries factor such matrices one after another on GPUs.

#pragma once

#include <cstdint>

namespace elastogen {

namespace cpu {
/// Q of A = Q R for each of (count, n, n) row-major matrices.
void orthonormal_bases(int64_t count, int n, const float* A, float* Q);
}  // namespace cpu

namespace cuda {
/// cpu::orthonormal_bases with pointers of the current device, on its default stream; n <= 160.
void orthonormal_bases(int64_t count, int n, const float* A, float* Q);
}  // namespace cuda

}  // namespace elastogen
