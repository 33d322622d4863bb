// SPDX-License-Identifier: Apache-2.0
// Builds without CUDA have no device.
#ifndef ELASTOGEN_CUDA

#include "core/error.hpp"
#include "network/step/step_work.hpp"

namespace elastogen::cuda {

std::unique_ptr<StepWork> make_device_step(const PotentialTerms&, const EncoderChoice*,
                                           const PaperLoops&) {
  throw Error("built without CUDA", ErrorKind::kDevice);
}

}  // namespace elastogen::cuda

#endif
