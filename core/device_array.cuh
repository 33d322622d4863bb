// SPDX-License-Identifier: Apache-2.0
// Memory of the device: owned, and copied to and from the host; and memory of the host that both
// reach.

#pragma once

#include "core/cuda_loop.cuh"

#include <mutex>
#include <utility>
#include <vector>

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

/// While one lives, the arrays that its thread makes take no room; it adds up what they would.
class RoomCount {
 public:
  RoomCount() { present() = this; }
  RoomCount(const RoomCount&) = delete;
  ~RoomCount() { present() = nullptr; }

  void add(size_t bytes) { bytes_ += bytes; }
  size_t bytes() const { return bytes_; }
  static RoomCount*& present() {
    static thread_local RoomCount* count = nullptr;
    return count;
  }

 private:
  size_t bytes_ = 0;
};

/// Owns numbers on the device, zeroed at birth. They are set and moved on the stream of the thread,
/// whatever the source is compiled for: threads with other scenes go on.
template <class T>
class DeviceArray {
 public:
  DeviceArray() = default;
  /// @throws Error (resources) where the device has no room.
  explicit DeviceArray(int64_t size) : size_(size) {
    if (size == 0) return;
    if (RoomCount* count = RoomCount::present()) {
      count->add(bytes());
      return;
    }
    check(cudaMalloc(&data_, bytes()));
    check(cudaMemsetAsync(data_, 0, bytes(), cudaStreamPerThread));
  }
  explicit DeviceArray(const std::vector<T>& host) : DeviceArray(int64_t(host.size())) {
    upload(host.data());
  }
  DeviceArray(DeviceArray&& other) noexcept
      : data_(std::exchange(other.data_, nullptr)), size_(std::exchange(other.size_, 0)) {}
  DeviceArray& operator=(DeviceArray&& other) noexcept {
    std::swap(data_, other.data_);
    std::swap(size_, other.size_);
    return *this;
  }
  ~DeviceArray() {
    if (!data_) return;
    const std::lock_guard lock(device_wide());
    cudaFree(data_);
  }

  T* data() { return data_; }
  const T* data() const { return data_; }
  int64_t size() const { return size_; }

  /// From and to size() numbers of the host.
  void upload(const T* host) { copy(data_, host, cudaMemcpyHostToDevice); }
  void download(T* host) const { copy(host, data_, cudaMemcpyDeviceToHost); }

 private:
  size_t bytes() const { return size_t(size_) * sizeof(T); }
  void copy(void* to, const void* from, cudaMemcpyKind kind) const {
    if (!data_) return;  // no numbers, or counted only
    check(cudaMemcpyAsync(to, from, bytes(), kind, cudaStreamPerThread));
    synchronise();
  }

  T* data_ = nullptr;
  int64_t size_ = 0;
};

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

}  // namespace elastogen::cuda
