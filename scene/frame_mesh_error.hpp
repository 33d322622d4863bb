// SPDX-License-Identifier: Apache-2.0
// The mesh number of a clip's frames (network/mesh_number/mesh_number.hpp), of runs on voxels of the
// network or of its element.

#pragma once

#include "network/mesh_number/mesh_number.hpp"
#include "scene/stepper.hpp"

#include <memory>
#include <optional>

namespace elastogen {

class FrameMeshError {
 public:
  /// Off where the run asks for none or steps no elastic voxels. All arguments must outlive it.
  FrameMeshError(const Setup& setup, const RunDescription& run, const CarriedPoints& points);

  /// Starts from the stepper's state. Where steps run on a card, whose positions have to be read,
  /// every eighth frame gets a number, and the last.
  void begin(Stepper& stepper);

  /// The number of the present state, at the end of a frame.
  std::optional<MeshError> of_frame(Stepper& stepper, int64_t frame);

 private:
  In<double> positions(Stepper& stepper) const;

  const Setup& setup_;
  const RunDescription& run_;
  const CarriedPoints& points_;
  std::unique_ptr<MeshNumber> number_;  ///< null: off
  int64_t stride_ = 1, last_ = 0;       ///< frames from number to number; frame of the last
};

/// Adds the number of a frame to that of the run.
void add_frame(const MeshError& frame, RunMeshError& run);

}  // namespace elastogen
