// SPDX-License-Identifier: Apache-2.0
// A machine that makes the passes of stages over nodes and points of contact: the host
// (host_stage_machine.cpp) or a card (device_stage_machine.cu). Their order stands in stages.cpp. Arrays
// are in its memory, (nodes, 3); of the pieces only a few numbers come to the host.

#pragma once

#include "core/stage_contact.hpp"
#include "network/step/piece_sums.hpp"
#include "network/step/stage_passes.hpp"
#include "network/step/stage_sums.hpp"

#include <vector>

namespace elastogen {

class StageMachine {
 public:
  virtual ~StageMachine() = default;

  virtual const Scene& scene() const = 0;
  virtual const Pieces& pieces() const = 0;
  /// The tables of the scene; the members of a step are not set.
  virtual StageNodes nodes() = 0;
  /// Where the first stage of SDIRK2 ends [m].
  virtual double* first_stage() = 0;
  /// Work space for one field at a time.
  virtual double* field() = 0;

  /// Numbers of the pieces for passes, valid until the next call with numbers of the kind.
  virtual const PiecePoses* put(const std::vector<PiecePoses>& of) = 0;
  virtual const PieceMotion* put(const std::vector<PieceMotion>& of) = 0;

  /// Runs a pass over all nodes.
  virtual void run(const NodePass& pass) = 0;
  /// Adds up over the nodes of each piece, in an order that never changes.
  virtual std::vector<PieceSums> sum(const NodeSum& sum) = 0;

  virtual bool has_contact() const = 0;
  /// Adds up what colliders do at a displacement u to each piece, (pieces).
  /// @param v        velocities at the start of the step [m/s].
  /// @param v_stage  velocities at the stage [m/s].
  /// @param about    points of the torques [m], (pieces).
  virtual ActionSums act(const double* u, const double* v, const double* v_stage,
                         const std::vector<Vec3>& about) = 0;
};

}  // namespace elastogen
