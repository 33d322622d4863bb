// SPDX-License-Identifier: Apache-2.0
// Tells the host that kernels have written numbers into its memory: by a word beside them, some
// microseconds before the host learns of the end of the kernel.

#pragma once

#include "core/cuda/array.cuh"

#include <atomic>

namespace elastogen::cuda {

class Signal {
 public:
  /// Called by the last thread that writes numbers, after all of them.
  struct Raise {
    unsigned* word;  ///< nullptr: nobody waits
    unsigned turn;
    unsigned* count = nullptr;  ///< on the device: turns are counted there
    __device__ void operator()() const {
      if (word == nullptr) return;
      const unsigned value = count == nullptr ? turn : ++*count;
      __threadfence_system();
      *static_cast<volatile unsigned*>(word) = value;
    }
  };

  /// For the next kernel that wait() waits for.
  Raise next() { return {word_.data(), ++turn_}; }

  /// Waits until the last Raise was called: all that the thread has launched up to it has written
  /// its numbers.
  /// @throws Error (resources) where a kernel failed.
  void wait() {
    constexpr int kSpins = 4096;  // some 10 us
    const std::atomic_ref<unsigned> word(word_[0]);
    for (int k = 1; word.load(std::memory_order_acquire) != turn_; ++k) {
      if (k % kSpins != 0) continue;
      const cudaError_t state = cudaStreamQuery(cudaStreamPerThread);
      if (state != cudaErrorNotReady) return check(state);
    }
  }

 private:
  friend class RepeatedSignal;
  PinnedArray<unsigned> word_{1};
  unsigned turn_ = 0;
};

/// A signal of kernels that are launched again and again as they are, as those of a graph.
class RepeatedSignal {
 public:
  /// What the last of these kernels calls.
  Signal::Raise raise() { return {signal_.word_.data(), 0, count_.data()}; }
  void expect() { ++signal_.turn_; }  ///< before each launch
  void wait() { signal_.wait(); }

 private:
  Signal signal_;
  DeviceArray<unsigned> count_{1};
};

}  // namespace elastogen::cuda
