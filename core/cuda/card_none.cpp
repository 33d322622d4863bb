// SPDX-License-Identifier: Apache-2.0
// Builds without CUDA have no device.
#ifndef ELASTOGEN_CUDA

#include "core/cuda/card.hpp"
#include "core/error.hpp"

namespace elastogen::cuda {

bool has_device() {
  return false;
}

std::string device_name() {
  throw Error("built without CUDA", ErrorKind::kDevice);
}

}  // namespace elastogen::cuda

#endif
