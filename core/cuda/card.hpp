// SPDX-License-Identifier: Apache-2.0
// The CUDA device, in builds with and without it.

#pragma once

#include <string>

namespace elastogen::cuda {

/// Whether there is a device to run on; false in builds without CUDA.
bool has_device();

/// Name of the device.
/// @throws Error (device) in builds without CUDA.
std::string device_name();

}  // namespace elastogen::cuda
