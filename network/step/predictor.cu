// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/held_nodes.cuh"
#include "network/step/device_step.cuh"
#include "network/step/predictor.hpp"

namespace elastogen::cuda {

void StepOnDevice::begin_step(const StepScheme& scheme, double time) {
  scheme_ = scheme;
  time_ = time;
  begin_loads();
  if (scheme.is_stage) return begin_stage();
  potential().held().set_time(time + scheme.end());
  const Motion m = motion();
  double *inertia = potential().inertia(), *predictor = potential().predictor(),
         *now = gradient_.data(), *u = quasi_.u();  // as in now()
  // predictor and start, then what depends on the displacement now
  cuda::for_each(size(), [=] __device__(int64_t k) {
    const int64_t n = k / 3;
    if (k % 3 == 0) inertia[n] = m.scheme.a0 * m.mass[n] / (m.scheme.dt * m.scheme.dt);
    const double away = m.x[k] - m.rest[k];
    double motion = 0;
    if (m.pinned[n] != kPinnedNode)
      motion = predicted_motion(m.scheme, m.x[k], m.v[k], m.x_before[k], m.v_before[k], m.pull(k));
    now[k] = away;
    predictor[k] = u[k] = away + motion;
  });
  has_rotations_ = false;
  potential().freeze_rotations(now);
  potential().begin_damping(scheme, now, before());
  pieces_.start(m.rest, m.mass, m.x, m.x_before, predictor, u);
  potential().held().place_pinned(predictor);
  potential().held().place(u);
  if (DeviceContact* contact = potential().contact()) contact->begin_step(now, time);
}

/// u_now, with held nodes where they are at the end of the step.
void StepOnDevice::find_now(double* to) {
  const double *x = x_.data(), *rest = potential().rest();
  cuda::for_each(size(), [=] __device__(int64_t k) { to[k] = x[k] - rest[k]; });
  if (potential().held().move()) potential().held().place(to);
}

/// Until iterations begin that is in the scratch of a trial; without contact it is u_now.
const Collider* StepOnDevice::clear_start() {
  DeviceContact* contact = potential().contact();
  return contact ? contact->clear_start(now(), quasi_.trial_u(), quasi_.u(), potential().held())
                 : nullptr;
}

void StepOnDevice::return_to_clear_start() {
  if (potential().contact())
    copy(quasi_.trial_u(), quasi_.u());
  else
    return_to_now();
  has_rotations_ = false;
}

bool StepOnDevice::is_below_clear_start() {
  const double* clear = potential().contact() ? quasi_.trial_u() : now();
  return rough_phi(quasi_.u()) < rough_phi(clear);
}

/// While the host waits nodal rotations are made, which hold unless u has to change.
double StepOnDevice::farthest() {
  const double *u = quasi_.u(), *x = x_.data(), *rest = potential().rest();
  StepNumbers* to = numbers_.data();
  const Signal::Raise raise = signal_.next();
  ordered_sum(
      size(), largest_.data(),
      [=] __device__(int64_t k, Largest & sum) { sum.add({fabs(u[k] - (x[k] - rest[k]))}); },
      [=] __device__(const Largest& sum) {
        to->farthest = sum.value;
        raise();
      });
  if (!potential().contact()) set_nodal_rotations();
  signal_.wait();
  return numbers_[0].farthest;
}

/// Predictor::extrapolate; pieces that it leaves alone are as in u.
void StepOnDevice::extrapolate(int order, double* to) {
  const Motion m = motion();
  const double* u = quasi_.u();
  cuda::for_each(size(), [=] __device__(int64_t k) {
    const double motion =
        m.pinned[k / 3] ? 0 : extrapolated_motion(m.scheme, order, m.v[k], m.v_before[k]);
    to[k] = m.x[k] - m.rest[k] + motion;
  });
  potential().held().place(to);
  if (!scene_.colliders.empty()) return;
  pieces_.for_each([=] __device__(int64_t, int64_t n) {
    for (int d = 0; d < 3; ++d) to[3 * n + d] = u[3 * n + d];
  });
}

/// All of them are evaluated before the host waits, where there is no contact, whose energy has a
/// single place.
void StepOnDevice::evaluate_starts(int count, double* phi) {
  double* const starts[DevicePotential::kEnergies] = {quasi_.u(), gradient_.data(),
                                                      quasi_.trial_u()};
  const bool one_by_one = potential().contact() != nullptr;
  const auto take = [&](int k) { phi[k] = potential().value(k).total(); };
  for (int k = 0; k < count; ++k) {
    if (k > 0) scheme_.is_stage ? stages_.value().start(k, starts[k]) : extrapolate(k, starts[k]);
    potential().start_energy(starts[k], k);
    if (!one_by_one) continue;
    potential().wait_for_energy();
    take(k);
  }
  if (one_by_one) return;
  potential().wait_for_energy();
  for (int k = 0; k < count; ++k) take(k);
}

void StepOnDevice::use_start(int start) {
  if (start == 1) copy(gradient_.data(), quasi_.u());
  if (start == 2) quasi_.accept_trial();
}

}  // namespace elastogen::cuda
