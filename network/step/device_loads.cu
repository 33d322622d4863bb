// SPDX-License-Identifier: Apache-2.0
// Loads that change, on the device: the host makes them (core/node_loads.hpp), of wind from positions
// and velocities that it gets from there.
#include "core/cuda/held_nodes.cuh"
#include "network/step/device_step.cuh"

namespace elastogen::cuda {
namespace {

/// Copies numbers of the nodes to the host.
void fetch_numbers(const double* from, int64_t nodes, Array<double>& to) {
  if (to.rows() != nodes) to = Array<double>(nodes, 3);
  check(cudaMemcpyAsync(to.data(), from, size_t(to.size()) * sizeof(double), cudaMemcpyDeviceToHost,
                        cudaStreamPerThread));
  synchronise();
}

}  // namespace

void StepOnDevice::begin_loads() {
  if (!has_changing_loads(scene_)) return;
  NodeLoads& loads = loads_.now;
  loads.begin(time_ + scheme_.end(), scheme_.response());
  const bool is_first = !scheme_.is_stage || scheme_.stage.t_b <= 0;
  if (is_first && loads.blows()) {
    fetch_numbers(x_.data(), size() / 3, loads_.x);
    fetch_numbers(v_.data(), size() / 3, loads_.v);
    loads.start_wind(loads_.x.data(), loads_.v.data());
  }
  check(cudaMemcpyAsync(potential().load(), loads.data(), size_t(size()) * sizeof(double),
                        cudaMemcpyHostToDevice, cudaStreamPerThread));
  synchronise();
}

/// Changes the loads of a step that has begun, and with them its predictor.
void StepOnDevice::put_loads() {
  gradient_.upload(loads_.now.data());
  const double *next = gradient_.data(), *inertia = potential().inertia();
  const uint8_t* pinned = potential().pinned();
  double *load = potential().load(), *predictor = potential().predictor();
  cuda::for_each(size(), [=] __device__(int64_t k) {
    if (pinned[k / 3] != kPinnedNode) predictor[k] += (next[k] - load[k]) / inertia[k / 3];
    load[k] = next[k];
  });
  potential().held().place_pinned(predictor);
}

bool StepOnDevice::renew_lags() {
  DeviceContact* contact = potential().contact();
  const bool rubs = scheme_.is_stage && contact && contact->renew_lag(quasi_.u());
  if (!loads_.now.blows()) return rubs;
  // positions are where certify() has put them, and velocities of steps of one length too
  if (scheme_.is_stage) stages_.value().velocities(quasi_.trial_u(), v_next_.data());
  fetch_numbers(quasi_.trial_u(), size() / 3, loads_.x);
  fetch_numbers(v_next_.data(), size() / 3, loads_.v);
  loads_.now.take_wind(loads_.x.data(), loads_.v.data());
  put_loads();
  return true;
}

void StepOnDevice::relax_lags(double share) {
  DeviceContact* contact = potential().contact();
  if (share < 1 && scheme_.is_stage && contact) contact->relax_lag(share);
  if (!loads_.now.blows()) return;
  loads_.now.relax_wind();
  put_loads();
}

}  // namespace elastogen::cuda
