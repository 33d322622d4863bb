// SPDX-License-Identifier: Apache-2.0
// Steps of stages on the device: those of host_step.cpp.
#include "core/cuda/held_nodes.cuh"
#include "network/precondition/preconditioner.cuh"
#include "network/step/device_step.cuh"

namespace elastogen::cuda {

/// Of another state nothing is known but itself.
void StepOnDevice::forget() {
  if (!stages_) return;
  stages_->forget();
  if (DeviceContact* contact = potential().contact()) contact->forget_bonds();
}

/// u_before, where damping needs it, in the scratch of a trial.
const double* StepOnDevice::before() {
  if (!potential().terms().has_damping() || !has_before_) return nullptr;
  const double *x = x_before_.data(), *rest = potential().rest();
  double* const to = quasi_.trial_u();
  cuda::for_each(size(), [=] __device__(int64_t k) { to[k] = x[k] - rest[k]; });
  return to;
}

void StepOnDevice::begin_stage() {
  potential().held().set_time(time_ + scheme_.end());
  const Motion m = motion();
  const double* way = stages_.value().begin({m.x, m.v, m.x_before, m.v_before}, scheme_);
  double *predictor = potential().predictor(), *now = gradient_.data();  // as in now()
  cuda::for_each(size(), [=] __device__(int64_t k) {
    now[k] = m.x[k] - m.rest[k];
    predictor[k] = now[k] + (m.pinned[k / 3] == kPinnedNode ? 0 : way[k]);
  });
  potential().held().place_pinned(predictor);
  has_rotations_ = false;
  potential().freeze_rotations(now);
  if (stages_->has_no_ledger()) open_ledger(now);
  potential().set_scheme(scheme_);
  const double t_b = scheme_.stage.t_b;
  potential().begin_damping(scheme_, now, t_b > 0 ? quasi_.u() : before());
  quasi_.preconditioner().update_inertia(scheme_);
  // u is still that of the first stage where this is the second one
  if (DeviceContact* contact = potential().contact())
    contact->begin_stage(now, time_, scheme_.end(), t_b > 0 ? quasi_.u() : now,
                         t_b > 0 ? time_ + t_b : time_);
  stages_->start(0, quasi_.u());
}

/// Opens the ledger of steps with the energies at the start, those of a step of no length.
void StepOnDevice::open_ledger(double* now) {
  const StepScheme at_once(TimeScheme::kEuler, euler_stage(kNoTime * scene_.dt));
  potential().set_scheme(at_once);
  potential().begin_damping(at_once, now, nullptr);
  if (DeviceContact* contact = potential().contact())
    contact->begin_stage(now, time_, at_once.end(), now, time_);
  const PotentialValue value = potential().evaluate(now, static_cast<double*>(nullptr));
  stages_->open_ledger(now, value.elastic + value.hourglass);
}

void StepOnDevice::keep_stage() {
  stages_.value().keep_stage(quasi_.u(), certificate_);
  if (has_changing_loads(scene_)) loads_.first = loads_.now.all();
}

StageEnd StepOnDevice::end_step(const TimeErrorOptions* options) {
  StageEnd end;
  // the positions are where certify() has put them
  end.keeps_energy =
      stages_.value().end_step(quasi_.trial_u(), quasi_.u(), certificate_, v_next_.data());
  end.guarded = stages_->guarded();
  end.ledger = stages_->ledger();
  if (options)
    end.error = stages_->error(v_next_.data(), *options,
                               [&](double* y) { newton_solver().filter(options->interval, y); });
  return end;
}

StageData StepOnDevice::stage_data() {
  StageData data;
  if (has_changing_loads(scene_)) data.load = loads_.now.all(), data.first_load = loads_.first;
  if (!stages_) return data;
  if (first_stage_.empty()) first_stage_ = Array<double>(size() / 3, 3);
  check(cudaMemcpy(first_stage_.data(), stage_machine_->first_stage(),
                   size_t(size()) * sizeof(double), cudaMemcpyDeviceToHost));
  if (DeviceContact* contact = potential().contact()) contact->download_bonds(bonds_);
  data.first = first_stage_, data.bonds = bonds_;
  return data;
}

/// The velocities of end_step() are those of the state that comes.
void StepOnDevice::accept_stages() {
  find_energies();
  signal_.wait();
  stages_->accept(time_ + scheme_.end());
  if (DeviceContact* contact = potential().contact()) contact->keep_bonds(quasi_.u());
  h_before_ = scheme_.end();
}

}  // namespace elastogen::cuda
