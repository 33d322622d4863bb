// SPDX-License-Identifier: Apache-2.0
// Memory of the host that does not leave its place: the bus moves it at its full rate, and kernels
// reach it.

#pragma once

#include "core/cuda_loop.cuh"
#include "core/parallel.hpp"

#include <cstring>
#include <mutex>

namespace elastogen::cuda {

/// Waits for what this thread has launched.
inline void synchronise() {
  check(cudaStreamSynchronize(cudaStreamPerThread));
}

/// Held while memory is freed, which waits for the whole device, and while a graph is recorded: a
/// stream that is being recorded may not be waited for, from no thread.
inline std::mutex& device_wide() {
  static std::mutex mutex;
  return mutex;
}

/// Owns numbers of the host that do not leave its memory: the bus moves them at its full rate, and
/// kernels write them in place. The host reads what kernels wrote after synchronise().
template <class T>
class PinnedArray {
 public:
  /// @throws Error (resources) where the host has no room.
  explicit PinnedArray(int64_t size) {
    if (size == 0) return;
    check(cudaHostAlloc(&data_, size_t(size) * sizeof(T), cudaHostAllocMapped));
    for (int64_t i = 0; i < size; ++i) data_[i] = T{};
  }
  PinnedArray(const PinnedArray&) = delete;
  ~PinnedArray() {
    if (!data_) return;
    const std::lock_guard lock(device_wide());
    cudaFreeHost(data_);
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  T& operator[](int64_t i) { return data_[i]; }
  const T& operator[](int64_t i) const { return data_[i]; }

 private:
  T* data_ = nullptr;
};

/// While one lives, what its thread uploads goes through two pinned chunks that all threads fill:
/// the driver fills its own with one, at a fraction of the rate of the bus.
class PinnedUpload {
 public:
  /// @throws Error (resources) where the host has no room.
  PinnedUpload() : room_(2 * kChunk) {
    for (cudaEvent_t& sent : sent_) check(cudaEventCreateWithFlags(&sent, cudaEventDisableTiming));
    present() = this;
  }
  PinnedUpload(const PinnedUpload&) = delete;
  ~PinnedUpload() {
    present() = nullptr;
    for (cudaEvent_t& sent : sent_) {
      cudaEventSynchronize(sent);
      cudaEventDestroy(sent);
    }
  }

  /// Sends on the stream of the thread; `from` is free again when it returns.
  void send(void* to, const void* from, size_t bytes) {
    for (size_t begin = 0; begin < bytes; begin += kChunk) {
      const size_t count = std::min(kChunk, bytes - begin);
      unsigned char* chunk = room_.data() + turn_ * kChunk;
      const auto* source = static_cast<const unsigned char*>(from) + begin;
      check(cudaEventSynchronize(sent_[turn_]));
      for_blocks(
          int64_t(count),
          [=](int64_t first, int64_t last) {
            std::memcpy(chunk + first, source + first, size_t(last - first));
          },
          kPiece);
      check(cudaMemcpyAsync(static_cast<unsigned char*>(to) + begin, chunk, count,
                            cudaMemcpyHostToDevice, cudaStreamPerThread));
      check(cudaEventRecord(sent_[turn_], cudaStreamPerThread));
      turn_ = 1 - turn_;
    }
  }

  static PinnedUpload*& present() {
    static thread_local PinnedUpload* upload = nullptr;
    return upload;
  }

 private:
  static constexpr size_t kChunk = size_t{2} << 20;
  static constexpr int64_t kPiece = int64_t{1} << 17;  // of a thread

  PinnedArray<unsigned char> room_;
  cudaEvent_t sent_[2] = {};
  size_t turn_ = 0;
};

}  // namespace elastogen::cuda
