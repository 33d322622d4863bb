// SPDX-License-Identifier: Apache-2.0
#include "network/step/host_frames.hpp"

namespace elastogen {

HostFrames::HostFrames(const VoxelGrid& grid, const Embedding& embedding, bool with_gradient)
    : grid_(grid), embedding_(embedding) {
  const int64_t points = embedding.voxel.rows();
  for (Slot& slot : slots_) {
    slot.displacement = Array<double>(points, 3);
    if (with_gradient) slot.gradient = Array<double>(points, 9);
  }
}

void HostFrames::make(int slot, const Array<double>& x) {
  deform_asset(grid_, embedding_, x, slots_[slot].displacement);
  if (!slots_[slot].gradient.empty())
    deformation_gradient(grid_, embedding_, x, slots_[slot].gradient);
}

CarriedFrame HostFrames::get(int slot) const {
  const Slot& frame = slots_[slot];
  return {frame.displacement.data(), frame.gradient.empty() ? nullptr : frame.gradient.data()};
}

}  // namespace elastogen
