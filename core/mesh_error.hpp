// SPDX-License-Identifier: Apache-2.0
// By how much the points of a body are displaced wrongly because voxels have a size, as an estimate
// (network/mesh_number/mesh_number.hpp).

#pragma once

#include <cstdint>

namespace elastogen {

struct MeshError {
  double rms = 0, largest = 0;  ///< over the points [m]
  bool trusted = true;          ///< false: voxels are too coarse for an estimate
};

/// That of a run: the largest numbers of its frames.
struct RunMeshError {
  int64_t frames = 0;           ///< that were estimated, without the first; 0: no estimate
  int64_t untrusted = 0;        ///< of these
  double rms = 0, largest = 0;  ///< [m]
  double largest_motion = 0;    ///< of a point's coordinate in the clip [m]
};

}  // namespace elastogen
