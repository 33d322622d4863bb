// SPDX-License-Identifier: Apache-2.0
// training/silu_jet.hpp as an operation of libtorch that can be differentiated once.

#pragma once

#include "training/silu_jet.hpp"

#include <ATen/core/Tensor.h>

namespace elastogen {

/// a = act(z + bias). @param z  (nets, rows, width) @param bias  (nets, width)
/// @throws Error unless both are contiguous float32 tensors on one device and of this shape.
at::Tensor silu_jet(const JetShape& shape, const at::Tensor& z, const at::Tensor& bias);

}  // namespace elastogen
