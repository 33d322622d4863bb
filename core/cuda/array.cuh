// SPDX-License-Identifier: Apache-2.0
// Memory of the device: owned, and copied to and from the host.

#pragma once

#include "core/cuda/pinned.cuh"

#include <utility>
#include <vector>

namespace elastogen::cuda {

/// While one lives, arrays that its thread makes allocate nothing; it counts what they would need.
class MemoryCount {
 public:
  MemoryCount() { present() = this; }
  MemoryCount(const MemoryCount&) = delete;
  ~MemoryCount() { present() = nullptr; }

  void add(size_t bytes) {
    bytes_ += bytes;
    most_ = most_ < bytes_ ? bytes_ : most_;
  }
  void take_off(size_t bytes) { bytes_ -= bytes; }  ///< of arrays that are freed
  size_t bytes() const { return bytes_; }
  size_t most() const { return most_; }  ///< largest count so far
  static MemoryCount*& present() {
    static thread_local MemoryCount* count = nullptr;
    return count;
  }

 private:
  size_t bytes_ = 0, most_ = 0;
};

/// Owns numbers on the device, 0 at first. They are set and copied on the stream of the thread, for
/// every default stream that the source is compiled for, so that threads with other scenes go on.
template <class T>
class DeviceArray {
 public:
  DeviceArray() = default;
  /// @throws Error (resources) if the device has too little memory.
  explicit DeviceArray(int64_t size) : size_(size) {
    if (size == 0) return;
    if (MemoryCount* count = MemoryCount::present()) {
      count->add(bytes());
      return;
    }
    check(cudaMalloc(&data_, bytes()));
    check(cudaMemsetAsync(data_, 0, bytes(), cudaStreamPerThread));
  }
  template <class Allocator>
  explicit DeviceArray(const std::vector<T, Allocator>& host) : DeviceArray(int64_t(host.size())) {
    upload(host.data());
  }
  DeviceArray(const T* host, int64_t size) : DeviceArray(size) { upload(host); }
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

  /// Copy from and to size() numbers of the host.
  void upload(const T* host) { upload(host, 0, size_); }
  void download(T* host) const { copy(host, data_, size_, cudaMemcpyDeviceToHost); }
  /// Copies only the numbers [begin, begin + count).
  void upload(const T* host, int64_t begin, int64_t count) {
    copy(data_ + begin, host, count, cudaMemcpyHostToDevice);
  }

 private:
  size_t bytes() const { return size_t(size_) * sizeof(T); }
  void copy(void* to, const void* from, int64_t count, cudaMemcpyKind kind) const {
    if (!data_ || count == 0) return;  // no numbers, or counted only
    PinnedChunks* upload = PinnedUpload::present();
    if (upload && kind == cudaMemcpyHostToDevice)
      return upload->send(to, from, size_t(count) * sizeof(T));
    check(cudaMemcpyAsync(to, from, size_t(count) * sizeof(T), kind, cudaStreamPerThread));
    synchronise();
  }

  T* data_ = nullptr;
  int64_t size_ = 0;
};

}  // namespace elastogen::cuda
