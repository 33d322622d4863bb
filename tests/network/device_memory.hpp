// SPDX-License-Identifier: Apache-2.0
// Occupies the card's memory, for tests of steps that find none.

#pragma once

#include <cuda_runtime_api.h>

#include <vector>

namespace elastogen::test {

/// Occupies all free memory of the card.
class AllMemory {
 public:
  AllMemory() {
    size_t free = 0, total = 0;
    cudaMemGetInfo(&free, &total);
    for (size_t size = free; size >= (1 << 20);) {
      void* block = nullptr;
      if (cudaMalloc(&block, size) == cudaSuccess)
        blocks_.push_back(block);
      else
        size /= 2, cudaGetLastError();
    }
  }
  ~AllMemory() {
    for (void* block : blocks_) cudaFree(block);
  }

 private:
  std::vector<void*> blocks_;
};

}  // namespace elastogen::test
