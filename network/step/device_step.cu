// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/held_nodes.cuh"
#include "core/parallel.hpp"
#include "network/step/device_step.cuh"
#include "network/step/memory_budget.cuh"

namespace elastogen::cuda {
namespace {

DeviceQuasi make_quasi(const PotentialTerms& terms, const EncoderChoice* encoder) {
  return encoder ? DeviceQuasi(terms, *encoder) : DeviceQuasi(terms);
}

}  // namespace

StepOnDevice::StepOnDevice(const PotentialTerms& terms, const EncoderChoice* encoder,
                           const PaperLoops& loops)
    : scene_(terms.scene()),
      quasi_(make_quasi(terms, encoder)),
      pieces_(scene_),
      x_(scene_.grid.rest.size()),
      v_(size()),
      x_before_(size()),
      v_before_(size()),
      gradient_(size()),
      largest_(1),
      pair_sums_(1),
      numbers_(1),
      loads_(scene_) {
  if (!encoder) paper_.emplace(quasi_, loops);
  if (pieces_.count() > 0 || has_stages(scene_.scheme) || potential().held().move() ||
      loads_.now.blows())
    v_next_ = DeviceArray<double>(size());
  if (!has_stages(scene_.scheme)) return;
  stage_machine_.emplace(potential());
  stages_.emplace(*stage_machine_);
}

void StepOnDevice::copy(const double* from, double* to) const {
  check(cudaMemcpyAsync(to, from, size_t(size()) * sizeof(double), cudaMemcpyDeviceToDevice,
                        cudaStreamPerThread));
}

void StepOnDevice::send(const Array<double>& from, DeviceArray<double>& to) {
  if (!chunks_) chunks_.emplace();
  chunks_->send(to.data(), from.data(), size_t(size()) * sizeof(double));
}

void StepOnDevice::fetch(const DeviceArray<double>& from, Array<double>& to) {
  if (to.size() != size()) to = Array<double>(size() / 3, 3);
  if (!chunks_) chunks_.emplace();
  chunks_->fetch(to.data(), from.data(), size_t(size()) * sizeof(double));
}

void StepOnDevice::upload(const State& state) {
  send(state);
  forget();
}

void StepOnDevice::borrow(State& state) {
  send(state);
  if (stages_ && !stages_->knows(state.time)) forget();
}

void StepOnDevice::send(const State& state) {
  has_before_ = !state.x_before.empty();
  h_before_ = state.h_before;
  send(state.x, x_);
  send(state.v, v_);
  if (!has_before_) return;
  send(state.x_before, x_before_);
  send(state.v_before, v_before_);
}

void StepOnDevice::download(State& state, StateParts parts) {
  fetch(x_, state.x);
  if (parts == StateParts::kPositions) return;
  fetch(v_, state.v);
  state.h_before = h_before_;
  if (has_before_) {
    fetch(x_before_, state.x_before);
    fetch(v_before_, state.v_before);
  } else {
    state.x_before = state.v_before = {};
  }
}

void StepOnDevice::upload_u(const double* u) {
  check(cudaMemcpy(quasi_.u(), u, size_t(size()) * sizeof(double), cudaMemcpyHostToDevice));
  has_rotations_ = false;
}

void StepOnDevice::download_u(double* u) {
  check(cudaMemcpy(u, quasi_.u(), size_t(size()) * sizeof(double), cudaMemcpyDeviceToHost));
}

Motion StepOnDevice::motion() {
  Motion m{x_.data(),
           v_.data(),
           has_before_ ? x_before_.data() : x_.data(),
           has_before_ ? v_before_.data() : v_.data(),
           potential().rest(),
           potential().mass(),
           potential().load(),
           potential().pinned(),
           scheme_,
           {}};
  for (size_t d = 0; d < 3; ++d) m.gravity[d] = scene_.gravity[d];
  return m;
}

double StepOnDevice::reach() {
  const double* x = x_.data();
  StepNumbers* to = numbers_.data();
  const Signal::Raise raise = signal_.next();
  ordered_sum(
      size(), largest_.data(), [=] __device__(int64_t k, Largest & sum) { sum.add({fabs(x[k])}); },
      [=] __device__(const Largest& sum) {
        to->reach = sum.value;
        raise();
      });
  signal_.wait();
  return numbers_[0].reach;
}

void StepOnDevice::set_nodal_rotations() {
  if (!has_rotations_) quasi_.set_nodal_rotations();
  has_rotations_ = true;
}

double StepOnDevice::phi_at(const double* u) {
  return potential().evaluate<double>(u, static_cast<double*>(nullptr)).total();
}

double StepOnDevice::rough_phi(const double* u) {
  potential().start_energy(u, 0);
  potential().wait_for_energy();
  return potential().value().total();
}

/// x_next = X + u on the nodes that move, the present x on the others; u = x_next - X.
void StepOnDevice::round_positions() {
  const Motion m = motion();
  const DeviceHeldNodes& held = potential().held();
  const bool moves = held.move();
  double *u = quasi_.u(), *x_next = quasi_.trial_u();
  cuda::for_each(size(), [=] __device__(int64_t k) {
    const double place = m.pinned[k / 3] && !moves ? m.x[k] : m.rest[k] + u[k];
    x_next[k] = place;
    u[k] = place - m.rest[k];
  });
  // nodes that follow others, from these where they are rounded
  held.follow(u);
  const WeightedSums of = held.dependent().sums();
  cuda::for_each(3 * of.count, [=] __device__(int64_t j) {
    const int64_t k = 3 * int64_t(of.nodes[j / 3]) + j % 3;
    x_next[k] = m.rest[k] + u[k];
    u[k] = x_next[k] - m.rest[k];
  });
}

/// Whether something feels a collider at u.
bool StepOnDevice::touches() {
  DeviceContact* contact = potential().contact();
  if (!contact) return false;
  contact->start_evaluation(quasi_.u(), static_cast<double*>(nullptr));
  synchronise();
  return contact->energy() != 0;
}

/// HostStep::balance.
bool StepOnDevice::balance() {
  if (paper_ || pieces_.count() == 0 || touches()) return false;
  const double* aim = potential().predictor();
  if (potential().contact()) copy(quasi_.u(), quasi_.trial_u());
  pieces_.match_means(potential().mass(), quasi_.u(), [=] __device__(int64_t k) { return aim[k]; });
  if (!touches()) return true;
  copy(quasi_.trial_u(), quasi_.u());
  return false;
}

/// |grad Phi|, and numbers of u that are not finite. The velocities of a stage come later, so that the
/// host waits for this.
void StepOnDevice::find_size() {
  const double *u = quasi_.u(), *g = gradient_.data();
  StepNumbers* to = numbers_.data();
  const Signal::Raise raise = scheme_.is_stage ? signal_.next() : Signal::Raise{};
  ordered_sum(
      size(), pair_sums_.data(),
      [=] __device__(int64_t k, Sums<2> & sum) {
        sum.value[0] += g[k] * g[k];
        sum.value[1] += isfinite(u[k]) ? 0 : 1;
      },
      [=] __device__(const Sums<2>& sum) {
        to->square = sum.value[0], to->not_finite = sum.value[1];
        raise();
      });
}

Certificate StepOnDevice::certify() {
  in_flight_ = balance();
  round_positions();
  potential().start_residual(quasi_.u(), gradient_.data());
  find_size();
  if (!scheme_.is_stage) {
    if (has_velocities()) find_velocities();
    find_energies();
  }
  signal_.wait();
  Certificate result{potential().value(), std::sqrt(numbers_[0].square)};
  result.reactions = potential().reactions();
  certificate_ = {result.value.elastic + result.value.hourglass,
                  damping_power(result.value, scheme_), potential().held().power(result.reactions),
                  gradient_.data()};
  result.finite = std::isfinite(result.value.total()) && std::isfinite(result.size) &&
                  numbers_[0].not_finite == 0;
  return result;
}

namespace {

/// Velocities after a step; pinned nodes rest.
struct NextVelocity {
  Motion m;
  const double* x_next;

  __device__ double operator()(int64_t k) const {
    if (m.pinned[k / 3] == kPinnedNode) return 0;
    return velocity_after(m.scheme, x_next[k], m.x[k], m.x_before[k]);
  }
};

}  // namespace

bool StepOnDevice::has_velocities() {
  return in_flight_ || scheme_.is_stage || potential().held().move() || loads_.now.blows();
}

/// Velocities that are not those of single nodes, or of holders, or that wind needs. In flight they lose what the
/// rounding of positions brings into their mean.
void StepOnDevice::find_velocities() {
  const Motion m = motion();
  const NextVelocity velocity{m, quasi_.trial_u()};
  double* v_next = v_next_.data();
  cuda::for_each(size(), [=] __device__(int64_t k) { v_next[k] = velocity(k); });
  potential().held().set_velocities(velocity.x_next, v_next);
  if (!in_flight_) return;
  pieces_.match_means(potential().mass(), v_next, [=] __device__(int64_t k) {
    return free_velocity(m.scheme, m.v[k], m.v_before[k], m.pull(k));
  });
}

void StepOnDevice::find_energies() {
  const Motion m = motion();
  const NextVelocity velocity{m, quasi_.trial_u()};
  const double* v_next = has_velocities() ? v_next_.data() : nullptr;
  StepNumbers* to = numbers_.data();
  const Signal::Raise raise = signal_.next();
  ordered_sum(
      size() / 3, pair_sums_.data(),
      [=] __device__(int64_t n, Sums<2> & sum) {
        for (int64_t k = 3 * n; k < 3 * n + 3; ++k) {
          const double v = v_next != nullptr ? v_next[k] : velocity(k);
          if (m.pinned[n] != kPinnedNode)  // the others go with what holds them
            sum.value[0] += m.mass[n] / 2 * v * v;
          sum.value[1] -= m.mass[n] * m.gravity[k - 3 * n] * velocity.x_next[k];
        }
      },
      [=] __device__(const Sums<2>& sum) {
        to->energy.kinetic = sum.value[0], to->energy.gravity = sum.value[1];
        raise();
      });
}

/// The arrays go round: those of the state before take what comes next.
MotionEnergy StepOnDevice::finish() {
  if (scheme_.is_stage) accept_stages();
  if (has_velocities()) {
    std::swap(v_before_, v_next_);
  } else {
    const NextVelocity velocity{motion(), quasi_.trial_u()};
    double* to = v_before_.data();
    cuda::for_each(size(), [=] __device__(int64_t k) { to[k] = velocity(k); });
  }
  std::swap(v_before_, v_);
  std::swap(x_before_, x_);
  std::swap(x_, quasi_.trial());
  has_before_ = true;
  return numbers_[0].energy;
}

size_t StepOnDevice::later_bytes() {
  if (paper_) return 0;
  return DeviceQuasi::later_bytes(size() / 3) + DeviceNewton::bytes(potential());
}

DeviceNewton& StepOnDevice::newton_solver() {
  if (!newton_) newton_.emplace(quasi_);
  return *newton_;
}

void StepOnDevice::carry(const Embedding& embedding, bool with_gradient) {
  frames_.reset();
  host_frames_.reset();
  frames_ = make_frames(scene_.grid, embedding, with_gradient, later_bytes());
  if (!frames_) host_frames_.emplace(scene_.grid, embedding, with_gradient);
}

void StepOnDevice::start_frame(int slot) {
  if (frames_) return frames_->start(slot, x_.data(), potential().rest());
  State read;
  download(read, StateParts::kPositions);
  host_frames_->make(slot, read.x);
}

namespace {

/// The arguments of a step, to make it once or twice (memory_budget.cuh).
struct Recipe {
  const PotentialTerms& terms;
  const EncoderChoice* encoder;
  const PaperLoops& loops;

  std::unique_ptr<StepOnDevice> make() const {
    return std::make_unique<StepOnDevice>(terms, encoder, loops);
  }
};

}  // namespace

std::unique_ptr<StepWork> make_device_step(const PotentialTerms& terms,
                                           const EncoderChoice* encoder, const PaperLoops& loops) {
  return within_budget(Recipe{terms, encoder, loops});
}

}  // namespace elastogen::cuda
