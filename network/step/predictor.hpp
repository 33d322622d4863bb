// SPDX-License-Identifier: Apache-2.0
// Start values of a step. A pinned piece starts at the predictor xhat of the time scheme, which
// knows of no elastic force, or where its velocities carry it (extrapolated_motion), as if the
// forces went on as they were: iterations begin where the potential is lowest. So does a free piece
// where there are colliders that it may lie on. In flight the straight line of xhat would stretch
// it by 1/cos of its turn, and a stiff one would start far away; it is predicted in its own frame
// instead,
//
//     x = chat + Rhat (2 d_n - d_{n-1}),     d = R^T (x - c),
//
// c and R the centre of mass and mean rotation of the piece, chat and Rhat those of xhat.

#pragma once

#include "core/state.hpp"
#include "core/time_scheme.hpp"

#include <vector>

namespace elastogen {

struct Scene;

class Predictor {
 public:
  explicit Predictor(const Scene& scene);

  /// Displacement u to start from, (nodes, 3). `predictor` is xhat - X of the step.
  void start(const State& state, const Zeroed<double>& predictor, double* u) const;
  /// Another one by extrapolated_motion, of pieces with a pin, and in a scene with colliders, on
  /// which they may lie, of free ones; leaves the others alone.
  void extrapolate(const State& state, const StepScheme& scheme, int order, double* u) const;
  /// The highest order that a state is good for.
  static int orders(bool has_before) { return has_before ? 2 : 1; }

 private:
  const Scene& scene_;
  std::vector<std::vector<int32_t>> free_pieces_;  // nodes of the pieces without a pin
  Zeroed<uint8_t> is_left_alone_;                  // by extrapolate, by node
};

}  // namespace elastogen
