// SPDX-License-Identifier: Apache-2.0
// The published algorithm on the device: RNN-1 and RNN-2 of paper_solver.hpp on what DeviceQuasi
// holds, its potential and displacement. Freezing is in float64; the encoder's products and the
// sweeps are in float, as in the published code's framework, or in double.

#pragma once

#include "network/solver.hpp"
#include "network/step/quasi_solver_device.hpp"

namespace elastogen::cuda {

class DevicePaper {
 public:
  /// @throws Error (usage) as check_paper_scene, (resources) where the device has too little memory.
  DevicePaper(DeviceQuasi& quasi, const PaperLoops& loops, bool float64 = false);
  ~DevicePaper();

  /// paper_loop on the displacement of the DeviceQuasi.
  IterationResult solve(const Interrupted& interrupted);

  struct Impl;  ///< in float or in double

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::cuda
