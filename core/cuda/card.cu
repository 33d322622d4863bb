// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/card.hpp"
#include "core/cuda/launch.cuh"

namespace elastogen::cuda {

bool has_device() {
  int count = 0;
  return cudaGetDeviceCount(&count) == cudaSuccess && count > 0;
}

std::string device_name() {
  cudaDeviceProp properties;
  int device = 0;
  check(cudaGetDevice(&device));
  check(cudaGetDeviceProperties(&properties, device));
  return properties.name;
}

}  // namespace elastogen::cuda
