// SPDX-License-Identifier: Apache-2.0
// Frames of a clip made on the host, two at a time.

#pragma once

#include "network/solver.hpp"
#include "voxelize/embedding.hpp"

namespace elastogen {

class HostFrames {
 public:
  /// @param grid, embedding  must outlive it.
  HostFrames(const VoxelGrid& grid, const Embedding& embedding, bool with_gradient);

  /// Makes a frame of positions x [m], (nodes, 3).
  /// @param slot  0 or 1; the frame that was there is gone.
  void make(int slot, const Array<double>& x);
  CarriedFrame get(int slot) const;

 private:
  struct Slot {
    Array<double> displacement, gradient;
  };
  const VoxelGrid& grid_;
  const Embedding& embedding_;
  Slot slots_[2];
};

}  // namespace elastogen
