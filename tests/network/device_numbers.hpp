// SPDX-License-Identifier: Apache-2.0
// Numbers of tests on the device.

#pragma once

#include <cuda_runtime_api.h>

#include <stdexcept>
#include <vector>

namespace elastogen::test {

/// Numbers on the device.
template <class T>
class OnDevice {
 public:
  explicit OnDevice(const std::vector<T>& host) : size_(host.size()) {
    if (cudaMalloc(reinterpret_cast<void**>(&data_), size_ * sizeof(T)) != cudaSuccess ||
        cudaMemcpy(data_, host.data(), size_ * sizeof(T), cudaMemcpyHostToDevice) != cudaSuccess)
      throw std::runtime_error("no room on the device");
  }
  ~OnDevice() { cudaFree(data_); }
  OnDevice(const OnDevice&) = delete;
  T* data() { return data_; }
  std::vector<T> host() const {
    std::vector<T> values(size_);
    if (cudaMemcpy(values.data(), data_, size_ * sizeof(T), cudaMemcpyDeviceToHost) != cudaSuccess)
      throw std::runtime_error(cudaGetErrorString(cudaGetLastError()));
    return values;
  }

 private:
  T* data_ = nullptr;
  size_t size_;
};

}  // namespace elastogen::test
