// SPDX-License-Identifier: Apache-2.0
#include "network/device_step_impl.cuh"
#include "network/predictor.hpp"

#include <cmath>

namespace elastogen::cuda {

void StepOnDevice::begin_step(const StepScheme& scheme, double time) {
  scheme_ = scheme;
  const Motion m = motion();
  double *inertia = potential().inertia(), *predictor = potential().predictor(),
         *now = potential().now(), *u = quasi_.u();
  cuda::for_each(size(), [=] __device__(int64_t k) {
    const int64_t n = k / 3;
    const int d = int(k % 3);
    if (d == 0) inertia[n] = m.scheme.a0 * m.mass[n] / (m.scheme.dt * m.scheme.dt);
    const double away = m.x[k] - m.rest[k];
    const double way = m.pinned[n] ? 0
                                   : predicted_motion(m.scheme, m.x[k], m.v[k], m.x_before[k],
                                                      m.v_before[k], m.gravity[d]);
    now[k] = away;
    predictor[k] = u[k] = away + way;
  });
  potential().freeze_rotations();
  pieces_.start(m.rest, m.mass, m.x, m.x_before, predictor, u);
  if (DeviceContact* contact = potential().contact()) contact->begin_step(now, time);
}

const Collider* StepOnDevice::clear_start() {
  DeviceContact* contact = potential().contact();
  return contact ? contact->clear_start(potential().now(), clear(), quasi_.u()) : nullptr;
}

double StepOnDevice::farthest() {
  const double *u = quasi_.u(), *now = potential().now();
  StepNumbers* to = numbers_.data();
  ordered_sum(
      size(), largest_.data(),
      [=] __device__(int64_t k, Largest & sum) { sum.add({fabs(u[k] - now[k])}); },
      [=] __device__(const Largest& sum) { to->farthest = sum.value; });
  synchronise();
  return numbers_[0].farthest;
}

/// Predictor::extrapolate; pieces that it leaves alone are as in u.
void StepOnDevice::extrapolate(int order, double* to) {
  const Motion m = motion();
  const double* u = quasi_.u();
  cuda::for_each(size(), [=] __device__(int64_t k) {
    const double way =
        m.pinned[k / 3] ? 0 : extrapolated_motion(m.scheme, order, m.v[k], m.v_before[k]);
    to[k] = m.x[k] - m.rest[k] + way;
  });
  if (!scene_.colliders.empty()) return;
  pieces_.for_each([=] __device__(int64_t, int64_t n) {
    for (int d = 0; d < 3; ++d) to[3 * n + d] = u[3 * n + d];
  });
}

/// Solver::Impl::choose_start.
void StepOnDevice::choose_start() {
  double lowest = rough_phi(quasi_.u());
  for (int order = 1; order <= Predictor::orders(has_before_); ++order) {
    extrapolate(order, quasi_.trial_u());
    const double phi = rough_phi(quasi_.trial_u());
    if (!(phi < lowest || std::isnan(lowest))) continue;
    lowest = phi;
    quasi_.accept_trial();
  }
}

}  // namespace elastogen::cuda
