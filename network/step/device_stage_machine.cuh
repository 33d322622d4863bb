// SPDX-License-Identifier: Apache-2.0
// The passes of stages on the device (stage_machine.hpp).

#pragma once

#include "core/cuda/groups.cuh"
#include "network/potential/incremental_potential_device.hpp"
#include "network/step/stage_machine.hpp"

namespace elastogen::cuda {

class DeviceStageMachine : public StageMachine {
 public:
  /// The potential must outlive it.
  /// @throws Error (resources) if the device has too little memory.
  explicit DeviceStageMachine(DevicePotential& potential);

  const Scene& scene() const override { return potential_.terms().scene(); }
  const Pieces& pieces() const override { return pieces_; }
  StageNodes nodes() override;
  double* first_stage() override { return first_stage_.data(); }
  double* field() override { return field_.data(); }
  const PiecePoses* put(const std::vector<PiecePoses>& of) override;
  const PieceMotion* put(const std::vector<PieceMotion>& of) override;
  void run(const NodePass& pass) override;
  /// Waits for the device.
  std::vector<PieceSums> sum(const NodeSum& sum) override;
  bool has_contact() const override { return potential_.contact() != nullptr; }
  ActionSums act(const double* u, const double* v, const double* v_stage,
                 const std::vector<Vec3>& about) override {
    return potential_.contact()->act(u, v, v_stage, about);
  }

 private:
  using DeviceSums = Sums<kPieceSums>;

  DevicePotential& potential_;
  Pieces pieces_;
  DeviceGroups groups_;         // nodes of the pieces
  DeviceArray<int32_t> piece_;  // of each node
  DeviceArray<uint8_t> kinds_;  // Pieces::kinds()
  DeviceArray<double> first_stage_, field_;
  DeviceArray<PiecePoses> poses_;
  DeviceArray<PieceMotion> motions_;
  DeviceArray<DeviceSums> parts_;  // of the chunks
  PinnedArray<DeviceSums> sums_;   // of the pieces
};

}  // namespace elastogen::cuda
