// SPDX-License-Identifier: Apache-2.0
// Start value of a step. A pinned piece starts at the predictor xhat of the time scheme. For a free
// piece that straight line stretches it by 1/cos of its turn, and a stiff piece then starts far
// away; it is predicted in its own frame instead,
//
//     x = chat + Rhat (2 d_n - d_{n-1}),     d = R^T (x - c),
//
// c and R the centre of mass and mean rotation of the piece, chat and Rhat those of xhat.

#pragma once

#include "core/state.hpp"

#include <vector>

namespace elastogen {

struct Scene;

class Predictor {
 public:
  explicit Predictor(const Scene& scene);

  /// Displacement u to start from, (nodes, 3). `predictor` is xhat - X of the step.
  void start(const State& state, const Zeroed<double>& predictor, double* u) const;

 private:
  const Scene& scene_;
  std::vector<std::vector<int32_t>> free_pieces_;  // nodes of the pieces without a pin
};

}  // namespace elastogen
