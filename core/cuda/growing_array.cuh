// SPDX-License-Identifier: Apache-2.0
// Memory of the device for numbers whose count changes, as for particles and bricks.

#pragma once

#include "core/cuda/array.cuh"

namespace elastogen::cuda {

/// The first size() of capacity() numbers on the device; on the stream of the thread, as a
/// DeviceArray.
template <class T>
class GrowingArray {
 public:
  GrowingArray() = default;

  T* data() { return numbers_.data(); }
  const T* data() const { return numbers_.data(); }
  int64_t size() const { return size_; }
  int64_t capacity() const { return numbers_.size(); }

  /// Allocates memory for that many numbers at least; the present ones stay. If it allocates,
  /// data() changes and the whole device is waited for.
  /// @throws Error (resources) if the device has too little memory; then all stays as it was.
  void reserve(int64_t capacity) {
    if (capacity <= this->capacity()) return;
    DeviceArray<T> larger(capacity);
    move(larger.data(), 0, size_);
    numbers_ = std::move(larger);
  }

  /// Numbers beyond the old size are 0. Grows by doubling, so that appending one by one copies
  /// rarely.
  /// @throws Error (resources) as reserve().
  void resize(int64_t size) {
    if (size > capacity()) reserve(size > 2 * capacity() ? size : 2 * capacity());
    if (size > size_ && data())
      check(cudaMemsetAsync(data() + size_, 0, bytes(size - size_), cudaStreamPerThread));
    size_ = size;
  }

  /// Copy all numbers from the host, and to it.
  void upload(const std::vector<T>& host) {
    resize(int64_t(host.size()));
    numbers_.upload(host.data(), 0, size_);
  }
  std::vector<T> download() const {
    std::vector<T> host(static_cast<size_t>(size_));
    if (!data() || size_ == 0) return host;
    check(cudaMemcpyAsync(host.data(), data(), bytes(size_), cudaMemcpyDeviceToHost,
                          cudaStreamPerThread));
    synchronise();
    return host;
  }

 private:
  static size_t bytes(int64_t count) { return size_t(count) * sizeof(T); }
  void move(T* to, int64_t begin, int64_t end) {
    if (!data() || begin == end) return;  // no numbers, or counted only
    check(cudaMemcpyAsync(to, data() + begin, bytes(end - begin), cudaMemcpyDeviceToDevice,
                          cudaStreamPerThread));
  }

  DeviceArray<T> numbers_;
  int64_t size_ = 0;
};

}  // namespace elastogen::cuda
