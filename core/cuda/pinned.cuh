// SPDX-License-Identifier: Apache-2.0
// Pinned memory of the host, which the system does not move: the bus copies it at its full rate,
// and kernels can access it.

#pragma once

#include "core/cuda/launch.cuh"
#include "core/parallel.hpp"

#include <cstring>
#include <mutex>
#include <vector>

namespace elastogen::cuda {

/// Waits for what this thread has launched.
inline void synchronise() {
  check(cudaStreamSynchronize(cudaStreamPerThread));
}

/// Held while memory is freed, which waits for the whole device, and while a graph is recorded: no
/// thread may wait for a stream that is being recorded.
inline std::mutex& device_wide() {
  static std::mutex mutex;
  return mutex;
}

/// Keeps pinned memory for later use: pinning costs a millisecond for any size, and another one for
/// each megabyte.
class PinnedPool {
 public:
  static constexpr size_t kLargest = size_t{4} << 20;  ///< that is kept

  static PinnedPool& instance() {
    static PinnedPool* pool = new PinnedPool;  // the driver may be gone before the last array is
    return *pool;
  }

  /// @throws Error (resources) if the host has too little memory.
  void* take(size_t bytes) {
    if (bytes > kLargest) return pin(bytes);
    const std::lock_guard lock(mutex_);
    std::vector<void*>& free = free_[size_class(bytes)];
    if (free.empty()) {
      const size_t size = kSmallest << size_class(bytes), count = size < kSlab ? kSlab / size : 1;
      auto* const slab = static_cast<unsigned char*>(pin(count * size));
      for (size_t k = 0; k < count; ++k) free.push_back(slab + (count - 1 - k) * size);
    }
    void* const taken = free.back();
    free.pop_back();
    return taken;
  }

  /// Waits for the device, which may still write there.
  void give_back(void* memory, size_t bytes) {
    {
      const std::lock_guard lock(device_wide());
      cudaDeviceSynchronize();
      if (bytes > kLargest) cudaFreeHost(memory);
    }
    if (bytes > kLargest) return;
    const std::lock_guard lock(mutex_);
    free_[size_class(bytes)].push_back(memory);
  }

 private:
  static constexpr size_t kSmallest = 256, kSlab = size_t{1} << 16;

  static size_t size_class(size_t bytes) {
    size_t k = 0;
    while ((kSmallest << k) < bytes) ++k;
    return k;
  }
  static void* pin(size_t bytes) {
    void* memory = nullptr;
    check(cudaHostAlloc(&memory, bytes, cudaHostAllocMapped | cudaHostAllocPortable));
    return memory;
  }

  std::mutex mutex_;
  std::vector<void*> free_[16];  // of kSmallest times powers of two
};

/// Owns numbers in pinned memory of the host: the bus copies them at its full rate, and kernels
/// write them in place. The host reads what kernels wrote after synchronise().
template <class T>
class PinnedArray {
 public:
  /// @throws Error (resources) if the host has too little memory.
  explicit PinnedArray(int64_t size) : size_(size) {
    if (size == 0) return;
    data_ = static_cast<T*>(PinnedPool::instance().take(bytes()));
    std::fill_n(data_, size, T{});
  }
  PinnedArray(const PinnedArray&) = delete;
  ~PinnedArray() {
    if (data_) PinnedPool::instance().give_back(data_, bytes());
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  T& operator[](int64_t i) { return data_[i]; }
  const T& operator[](int64_t i) const { return data_[i]; }

 private:
  size_t bytes() const { return size_t(size_) * sizeof(T); }

  T* data_ = nullptr;
  int64_t size_;
};

/// Two pinned chunks through which numbers of the host are copied, both ways, on the stream of the
/// thread; all threads fill and empty them. The driver fills its own with one, at a fraction of the
/// rate of the bus; pinning all numbers would cost more than copying them.
class PinnedChunks {
 public:
  /// @throws Error (resources) if the host has too little memory.
  PinnedChunks() : buffer_(2 * kChunk) {
    for (cudaEvent_t& moved : moved_)
      check(cudaEventCreateWithFlags(&moved, cudaEventDisableTiming));
  }
  PinnedChunks(const PinnedChunks&) = delete;
  ~PinnedChunks() {
    for (cudaEvent_t& moved : moved_) {
      cudaEventSynchronize(moved);
      cudaEventDestroy(moved);
    }
  }

  /// Copies to the device; `from` may be reused when it returns.
  void send(void* to, const void* from, size_t bytes) {
    for (size_t begin = 0; begin < bytes; begin += kChunk, turn_ = 1 - turn_) {
      const size_t count = std::min(kChunk, bytes - begin);
      check(cudaEventSynchronize(moved_[turn_]));
      copy(chunk(turn_), at(from, begin), count);
      move(at(to, begin), chunk(turn_), count, cudaMemcpyHostToDevice);
    }
  }

  /// Copies from the device; complete when it returns.
  void fetch(void* to, const void* from, size_t bytes) {
    size_t before = 0;  // bytes of the chunk that is under way
    for (size_t begin = 0; begin < bytes || before > 0; begin += kChunk) {
      const size_t count = begin < bytes ? std::min(kChunk, bytes - begin) : 0;
      if (count > 0) move(chunk(turn_), at(from, begin), count, cudaMemcpyDeviceToHost);
      turn_ = 1 - turn_;
      if (before > 0) {
        check(cudaEventSynchronize(moved_[turn_]));
        copy(at(to, begin - kChunk), chunk(turn_), before);
      }
      before = count;
    }
  }

 private:
  static constexpr size_t kChunk = size_t{2} << 20;
  static constexpr int64_t kPiece = int64_t{1} << 17;  // of a thread

  static void* at(void* from, size_t begin) { return static_cast<unsigned char*>(from) + begin; }
  static const void* at(const void* from, size_t begin) {
    return static_cast<const unsigned char*>(from) + begin;
  }
  unsigned char* chunk(size_t turn) { return buffer_.data() + turn * kChunk; }
  void move(void* to, const void* from, size_t bytes, cudaMemcpyKind kind) {
    check(cudaMemcpyAsync(to, from, bytes, kind, cudaStreamPerThread));
    check(cudaEventRecord(moved_[turn_], cudaStreamPerThread));
  }
  static void copy(void* to, const void* from, size_t bytes) {
    for_blocks(
        int64_t(bytes),
        [=](int64_t first, int64_t last) {
          std::memcpy(at(to, size_t(first)), at(from, size_t(first)), size_t(last - first));
        },
        kPiece);
  }

  PinnedArray<unsigned char> buffer_;
  cudaEvent_t moved_[2] = {};
  size_t turn_ = 0;
};

/// While one lives, uploads of its thread go through its chunks.
class PinnedUpload {
 public:
  PinnedUpload() { present() = &chunks_; }
  PinnedUpload(const PinnedUpload&) = delete;
  ~PinnedUpload() { present() = nullptr; }

  static PinnedChunks*& present() {
    static thread_local PinnedChunks* chunks = nullptr;
    return chunks;
  }

 private:
  PinnedChunks chunks_;
};

}  // namespace elastogen::cuda
