// SPDX-License-Identifier: Apache-2.0
#include "training/orthonormal_basis.hpp"

#include "training/orthonormal_basis_impl.hpp"

#include <ATen/Parallel.h>

#include <vector>

namespace elastogen::cpu {

void orthonormal_bases(int64_t count, int n, const float* A, float* Q) {
  const int64_t size = int64_t(n) * n;
  at::parallel_for(0, count, 1, [&](int64_t begin, int64_t end) {
    std::vector<float> tau(static_cast<size_t>(n));
    for (int64_t m = begin; m < end; ++m) {
      std::vector<float> work(A + m * size, A + (m + 1) * size);
      householder::orthonormal_basis(householder::Alone{}, n, work.data(), tau.data(),
                                     Q + m * size);
    }
  });
}

}  // namespace elastogen::cpu
