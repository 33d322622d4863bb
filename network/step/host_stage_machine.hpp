// SPDX-License-Identifier: Apache-2.0
// The passes of stages on the host (stage_machine.hpp).

#pragma once

#include "network/potential/incremental_potential.hpp"
#include "network/step/stage_machine.hpp"

namespace elastogen {

class HostStageMachine : public StageMachine {
 public:
  /// The potential must outlive it.
  explicit HostStageMachine(IncrementalPotential& potential);

  const Scene& scene() const override { return potential_.scene(); }
  const Pieces& pieces() const override { return pieces_; }
  StageNodes nodes() override;
  double* first_stage() override { return first_stage_.data(); }
  double* field() override { return field_.data(); }
  const PiecePoses* put(const std::vector<PiecePoses>& of) override { return of.data(); }
  const PieceMotion* put(const std::vector<PieceMotion>& of) override { return of.data(); }
  void run(const NodePass& pass) override;
  std::vector<PieceSums> sum(const NodeSum& sum) override;
  bool has_contact() const override { return potential_.contact().exists(); }
  ActionSums act(const double* u, const double* v, const double* v_stage,
                 const std::vector<Vec3>& about) override {
    return potential_.contact().act(u, v, v_stage, about);
  }

 private:
  IncrementalPotential& potential_;
  Pieces pieces_;
  std::vector<int32_t> first_;  // node of each piece
  Zeroed<double> first_stage_, field_;
};

}  // namespace elastogen
