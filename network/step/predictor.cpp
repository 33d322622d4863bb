// SPDX-License-Identifier: Apache-2.0
#include "network/step/predictor.hpp"

#include "core/parallel.hpp"
#include "core/polar.hpp"
#include "core/scene.hpp"
#include "network/step/free_flight.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

struct Frame {
  double centre[3] = {};
  Mat3<double> rotation = identity<double>();
};

/// Centre of mass and mean rotation of a piece at positions x.
Frame mean_frame(const Scene& scene, const std::vector<int32_t>& nodes, const Array<double>& x) {
  Frame frame;
  double mass = 0, rest[3] = {};
  for (const int32_t n : nodes) {
    mass += scene.mass(n);
    for (int i = 0; i < 3; ++i) {
      frame.centre[i] += scene.mass(n) * x(n, i);
      rest[i] += scene.mass(n) * scene.grid.rest(n, i);
    }
  }
  for (int i = 0; i < 3; ++i) frame.centre[i] /= mass, rest[i] /= mass;
  Mat3<double> A{};
  for (const int32_t n : nodes)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j)
        A(i, j) += scene.mass(n) * (x(n, i) - frame.centre[i]) * (scene.grid.rest(n, j) - rest[j]);
  frame.rotation = polar_rotation(A);
  return frame;
}

/// Whether a piece neither turns nor has turned: then the straight predictor is kept to the bit.
bool steady(const Frame& before, const Frame& now, const Frame& next) {
  double largest = 0;
  for (int k = 0; k < 9; ++k)
    for (const double turn :
         {now.rotation.m[k] - before.rotation.m[k], next.rotation.m[k] - now.rotation.m[k]})
      largest = std::max(largest, std::abs(turn));
  return largest < 1e-9;
}

}  // namespace

Predictor::Predictor(const Scene& scene)
    : scene_(scene),
      free_pieces_(free_pieces(scene)),
      is_left_alone_(size_t(scene.grid.node_count())) {
  if (!scene.colliders.empty()) return;
  for (const auto& nodes : free_pieces_)
    for_each(int64_t(nodes.size()),
             [&](int64_t k) { is_left_alone_[size_t(nodes[size_t(k)])] = 1; });
}

void Predictor::extrapolate(const State& state, const StepScheme& scheme, int order,
                            double* u) const {
  const Array<double>& X = scene_.grid.rest;
  for_each(X.rows(), [&](int64_t n) {
    if (is_left_alone_[size_t(n)]) return;
    for (int d = 0; d < 3; ++d) {
      const double v_before = order == 1 ? 0 : state.v_before(n, d);
      const double motion =
          scene_.pinned(n) ? 0 : extrapolated_motion(scheme, order, state.v(n, d), v_before);
      u[3 * n + d] = state.x(n, d) - X(n, d) + motion;
    }
  });
}

void Predictor::start(const State& state, const Zeroed<double>& predictor, double* u) const {
  const Array<double>& X = scene_.grid.rest;
  std::copy(predictor.begin(), predictor.end(), u);
  Array<double> predicted = X;
  for (int64_t k = 0; k < X.size(); ++k) predicted.data()[k] += predictor[size_t(k)];
  // free pieces that turn are predicted in their own frames
  const Array<double>& x_before = state.x_before.empty() ? state.x : state.x_before;
  for_each(
      int64_t(free_pieces_.size()),
      [&](int64_t p) {
        const std::vector<int32_t>& nodes = free_pieces_[size_t(p)];
        const Frame now = mean_frame(scene_, nodes, state.x);
        const Frame before = mean_frame(scene_, nodes, x_before);
        const Frame next = mean_frame(scene_, nodes, predicted);
        if (steady(before, now, next)) return;
        for (const int32_t n : nodes)
          for (int i = 0; i < 3; ++i) {
            double sum = next.centre[i] - X(n, i);
            for (int j = 0; j < 3; ++j) {
              double shape = 0;
              for (int k = 0; k < 3; ++k)
                shape += 2 * now.rotation(k, j) * (state.x(n, k) - now.centre[k]) -
                         before.rotation(k, j) * (x_before(n, k) - before.centre[k]);
              sum += next.rotation(i, j) * shape;
            }
            u[3 * int64_t(n) + i] = sum;
          }
      },
      1);
}

}  // namespace elastogen
