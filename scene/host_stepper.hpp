// SPDX-License-Identifier: Apache-2.0
// A stepper whose state lies on the host, where frames are made from its positions.

#pragma once

#include "scene/stepper.hpp"

#include <optional>

namespace elastogen {

/// Yields for a state file: the kind of each, and its parameters in the order of declaration,
/// (materials, 5).
Array<double> yield_rows(const std::vector<Yield>& yields);

class HostStepper : public Stepper {
 public:
  /// @param grid  the grid of the scene; must outlive it.
  explicit HostStepper(const VoxelGrid& grid) : grid_(grid) {}

  void begin_at(const State& state) override { state_ = state; }
  const State& state() override { return state_; }
  bool fits_single() const override;
  void carry(const CarriedPoints& points, bool with_gradient) override {
    frames_.emplace(grid_, points, with_gradient);
  }
  int64_t start_frame() override { return frames_->make(state_.x); }
  CarriedFrame take_frame(int64_t number) const override { return frames_->take(number); }

 protected:
  State state_;  ///< the present one

 private:
  const VoxelGrid& grid_;
  std::optional<NodeFrames> frames_;
};

}  // namespace elastogen
