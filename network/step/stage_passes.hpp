// SPDX-License-Identifier: Apache-2.0
// What stages do with each node. Arrays are (nodes, 3), in the memory of the machine. Shared by host
// and device.

#pragma once

#include "core/time_error.hpp"
#include "network/step/stage_nodes.hpp"

#include <variant>

namespace elastogen {

/// motion = xhat - x0.
struct PredictMotion {
  StageNodes of;
  double* motion;
  ELASTOGEN_HD void operator()(int64_t n) const { set_vector(motion, n, of.predicted(n)); }
};

/// u of a start (Stages::start).
struct StartDisplacement {
  StageNodes of;
  int order;
  const double* motion;
  double* u;
  ELASTOGEN_HD void operator()(int64_t n) const {
    Vec3 way = {};
    if (!of.pinned[n] && order == 0) {
      const Vec3 turning = of.reference_pull(of.poses_of(n).end, n);
      way = plus(vector_at(motion, n), scaled(turning, of.stage.k * of.stage.k));
    } else if (!of.pinned[n]) {
      way = of.extrapolated(n, order);
    }
    set_vector(u, n, plus(minus(of.x0(n), vector_at(of.rest, n)), way));
  }
};

/// x = X + u.
struct PlaceNodes {
  StageNodes of;
  const double* u;
  double* x;
  ELASTOGEN_HD void operator()(int64_t n) const {
    set_vector(x, n, plus(vector_at(of.rest, n), vector_at(u, n)));
  }
};

/// v of the stage at x, of dependent nodes too, as x follows that of their parent nodes; pinned nodes
/// rest.
struct TakeVelocities {
  StageNodes of;
  const double* x;
  double* v;
  ELASTOGEN_HD void operator()(int64_t n) const {
    set_vector(v, n, of.pinned[n] == kPinnedNode ? Vec3{} : of.velocity(n, vector_at(x, n)));
  }
};

/// field = before field + share times the rigid motion of the piece.
struct AddRigidMotion {
  StageNodes of;
  const PieceMotion* motions;
  double before, share;
  const double* x;
  double* field;
  ELASTOGEN_HD void operator()(int64_t n) const {
    const Vec3 part = scaled(motions[of.piece[n]].at(vector_at(x, n)), share);
    set_vector(field, n, plus(scaled(vector_at(field, n), before), part));
  }
};

/// D = the velocities of loose pieces relative to their references, 0 of the others.
struct RelativeVelocities {
  StageNodes of;
  const double* v;
  double* D;
  ELASTOGEN_HD void operator()(int64_t n) const {
    set_vector(D, n, of.poses_of(n).is_loose ? of.e1(n, v) : Vec3{});
  }
};

/// v += share D.
struct AddPart {
  const double* D;
  double share;
  double* v;
  ELASTOGEN_HD void operator()(int64_t n) const {
    set_vector(v, n, plus(vector_at(v, n), scaled(vector_at(D, n), share)));
  }
};

/// y of time_error.hpp; 0 at pinned nodes.
struct CombineVelocities {
  StageNodes of;
  StepWeights weights;
  const double* v;
  double* y;
  ELASTOGEN_HD void operator()(int64_t n) const {
    Vec3 sum = {};
    if (!of.pinned[n]) {
      sum = plus(scaled(of.e1(n, v), weights.end), scaled(of.e0(n), weights.start));
      if (weights.other != 0) sum = plus(sum, scaled(of.e_b(n), weights.other));
    }
    set_vector(y, n, sum);
  }
};

using NodePass = std::variant<PredictMotion, StartDisplacement, PlaceNodes, TakeVelocities,
                              AddRigidMotion, RelativeVelocities, AddPart, CombineVelocities>;

/// Completes the results of passes that leave held nodes at rest, on either machine.
/// @param held  has place, set_velocities and fill, as HeldNodes.
template <class Pass, class Held>
void complete_held(const Pass& pass, const Held& held) {
  if constexpr (std::is_same_v<Pass, StartDisplacement>)
    held.place(pass.u);
  else if constexpr (std::is_same_v<Pass, TakeVelocities>)
    held.set_velocities(pass.x, pass.v);
  else if constexpr (std::is_same_v<Pass, CombineVelocities>)
    held.fill(pass.y);
}

}  // namespace elastogen
