// SPDX-License-Identifier: Apache-2.0
// SiLU of the jets of many nets at once, and its derivative; the formulas are in silu_jet_impl.hpp.
//
// z and a are (nets, rows, width), row-major. The rows form a block of 10 channels, then a block of
// 4; within a block row = channel * points + point. A linear layer on all channels is then one
// matrix product for each net.

#pragma once

#include <cstdint>

namespace elastogen {

struct JetShape {
  int64_t nets = 0;
  int64_t second = 0;  ///< points with second derivatives, in the block of 10 channels
  int64_t first = 0;   ///< points without them, in the block of 4 channels
  int64_t width = 0;   ///< neurons, a multiple of 8

  int64_t rows() const { return 10 * second + 4 * first; }
};

namespace cpu {

/// a = act(z + bias), with the bias (nets, width) on the value channel only.
void silu_jet(const JetShape& shape, const float* z, const float* bias, float* a);

/// dz, the gradient with respect to z, from g, the gradient with respect to a.
void silu_jet_gradient(const JetShape& shape, const float* z, const float* bias, const float* g,
                       float* dz);

}  // namespace cpu

namespace cuda {

/// cpu::silu_jet and its gradient with pointers of the current device, on its default stream.
void silu_jet(const JetShape& shape, const float* z, const float* bias, float* a);
void silu_jet_gradient(const JetShape& shape, const float* z, const float* bias, const float* g,
                       float* dz);

}  // namespace cuda
}  // namespace elastogen
