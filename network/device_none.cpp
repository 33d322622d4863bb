// SPDX-License-Identifier: Apache-2.0
// Builds without CUDA have no device.
#ifndef ELASTOGEN_CUDA

#include "core/error.hpp"
#include "network/device.hpp"

namespace elastogen::cuda {

std::unique_ptr<DeviceStep> make_device_step(const PotentialTerms&, const EncoderChoice&) {
  throw Error("built without CUDA", ErrorKind::kDevice);
}

std::unique_ptr<DeviceStep> make_device_step(const PotentialTerms&, const PaperLoops&) {
  throw Error("built without CUDA", ErrorKind::kDevice);
}

}  // namespace elastogen::cuda

#endif
