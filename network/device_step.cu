// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.hpp"
#include "network/device.hpp"
#include "network/device_budget.cuh"
#include "network/device_frames.cuh"
#include "network/device_newton.hpp"
#include "network/device_paper.hpp"
#include "network/device_pieces.cuh"
#include "network/device_quasi.hpp"

#include <optional>

namespace elastogen::cuda {
namespace {

/// What a step reads of the state and of its scene.
struct Motion {
  const double *x, *v, *x_before, *v_before;  ///< those before are those now in an Euler step
  const double *rest, *mass;
  const uint8_t* pinned;
  StepScheme scheme;
  double gravity[3];
};

/// The largest of what it is given.
struct Largest {
  double value = 0;
  __device__ void add(const Largest& o) { value = o.value > value ? o.value : value; }
};

/// Where kernels leave what the host asks for.
struct StepNumbers {
  double farthest, reach, square, not_finite;
  MotionEnergy energy;
};

class StepOnDevice : public DeviceStep {
 public:
  /// With a first matrix, or for the published algorithm without one.
  StepOnDevice(const IncrementalPotential& potential, const Preconditioner<float>* first,
               const PaperLoops* paper);

  void upload(const State& state) override;
  void download(State& state, StateParts parts) override;
  bool has_before() const override { return has_before_; }
  void begin_step(const StepScheme& scheme, double time) override;
  const Collider* clear_start() override;
  double farthest() override;
  void return_to_now() override { copy(potential().now(), quasi_.u()); }
  void return_to_clear_start() override { copy(clear(), quasi_.u()); }
  double phi() override { return phi_at(quasi_.u()); }
  double phi_now() override { return phi_at(potential().now()); }
  bool is_below_clear_start() override { return rough_phi(quasi_.u()) < rough_phi(clear()); }
  void set_nodal_rotations() override { quasi_.set_nodal_rotations(); }
  IterationResult solve(double target, int max_outer, bool float64,
                        const std::function<bool()>& interrupted) override {
    return quasi_.solve(target, max_outer, float64, interrupted);
  }
  void upload_u(const double* u) override;
  void download_u(double* u) override;
  IterationResult newton(double target, int max_outer, int max_inner,
                         const std::function<bool()>& interrupted) override {
    if (!newton_) newton_.emplace(quasi_);
    return newton_->solve(target, max_outer, max_inner, interrupted);
  }
  IterationResult paper(const std::function<bool()>& interrupted) override {
    return paper_.value().solve(interrupted);
  }
  Certificate certify(bool may_fly) override;
  MotionEnergy finish(bool in_flight) override;
  void download_gradient(double* gradient) const override { gradient_.download(gradient); }
  double reach() override;
  bool carry(const Embedding& embedding, bool with_gradient) override {
    frames_.reset();
    frames_ = make_frames(scene_.grid, embedding, with_gradient, later_bytes());
    return frames_ != nullptr;
  }
  void start_frame(int slot) override { frames_->start(slot, x_.data(), rest_.data()); }
  CarriedFrame take_frame(int slot) const override { return frames_->take(slot); }

  /// What steps take beyond what the constructor does, at most.
  size_t later_bytes() {
    if (paper_) return 0;
    return DeviceQuasi::later_bytes(size() / 3) + DeviceNewton::bytes(potential());
  }

  // called by the above; kernels may not be started from private functions
  DevicePotential& potential() { return quasi_.potential(); }
  Motion motion();
  void round_positions();
  bool balance();
  void find_velocities();
  void find_energies();

 private:
  int64_t size() const { return x_.size(); }
  /// u_now, or in a scene with colliders what clear_start() has made of it, until iterations begin.
  double* clear() { return potential().contact() ? quasi_.trial_u() : potential().now(); }
  bool touches();
  void copy(const double* from, double* to) const;
  double phi_at(const double* u);
  double rough_phi(const double* u) {
    return potential().evaluate(u, static_cast<float*>(nullptr)).total();
  }
  void send(const Array<double>& from, DeviceArray<double>& to);
  void fetch(const DeviceArray<double>& from, Array<double>& to);

  const Scene& scene_;
  DeviceQuasi quasi_;
  std::optional<DeviceNewton> newton_;  // from its first step on
  std::optional<DevicePaper> paper_;
  DevicePieces pieces_;
  DeviceArray<double> rest_, mass_;
  DeviceArray<double> x_, v_, x_before_, v_before_;  // the state
  DeviceArray<double> x_next_, v_next_;              // until it is taken
  DeviceArray<double> gradient_;                     // of the certificate
  DeviceArray<SumRoom<Largest>> largest_;
  DeviceArray<SumRoom<Sums<2>>> pair_sums_;
  PinnedArray<StepNumbers> numbers_;
  PinnedArray<double> staging_;  // arrays on their way; the bus takes other memory more slowly
  std::unique_ptr<DeviceFrames> frames_;
  StepScheme scheme_;
  bool has_before_ = false;
};

DeviceQuasi make_quasi(const IncrementalPotential& potential, const Preconditioner<float>* first) {
  return first ? DeviceQuasi(potential, *first) : DeviceQuasi(potential);
}

StepOnDevice::StepOnDevice(const IncrementalPotential& potential,
                           const Preconditioner<float>* first, const PaperLoops* paper)
    : scene_(potential.scene()),
      quasi_(make_quasi(potential, first)),
      pieces_(scene_),
      rest_(scene_.grid.rest.data(), scene_.grid.rest.size()),
      mass_(scene_.mass.data(), scene_.mass.size()),
      x_(rest_.size()),
      v_(size()),
      x_before_(size()),
      v_before_(size()),
      x_next_(size()),
      v_next_(size()),
      gradient_(size()),
      largest_(1),
      pair_sums_(1),
      numbers_(1),
      staging_(size()) {
  if (paper) paper_.emplace(quasi_, *paper);
}

void StepOnDevice::copy(const double* from, double* to) const {
  check(cudaMemcpyAsync(to, from, size_t(size()) * sizeof(double), cudaMemcpyDeviceToDevice,
                        cudaStreamPerThread));
}

void StepOnDevice::send(const Array<double>& from, DeviceArray<double>& to) {
  for_blocks(size(), [&](int64_t begin, int64_t end) {
    std::copy(from.data() + begin, from.data() + end, staging_.data() + begin);
  });
  to.upload(staging_.data());
}

void StepOnDevice::fetch(const DeviceArray<double>& from, Array<double>& to) {
  from.download(staging_.data());
  if (to.size() != size()) to = Array<double>(size() / 3, 3);
  for_blocks(size(), [&](int64_t begin, int64_t end) {
    std::copy(staging_.data() + begin, staging_.data() + end, to.data() + begin);
  });
}

void StepOnDevice::upload(const State& state) {
  has_before_ = !state.x_before.empty();
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
  if (has_before_) {
    fetch(x_before_, state.x_before);
    fetch(v_before_, state.v_before);
  } else {
    state.x_before = state.v_before = {};
  }
}

void StepOnDevice::upload_u(const double* u) {
  check(cudaMemcpy(quasi_.u(), u, size_t(size()) * sizeof(double), cudaMemcpyHostToDevice));
}

void StepOnDevice::download_u(double* u) {
  check(cudaMemcpy(u, quasi_.u(), size_t(size()) * sizeof(double), cudaMemcpyDeviceToHost));
}

Motion StepOnDevice::motion() {
  Motion m{x_.data(),
           v_.data(),
           has_before_ ? x_before_.data() : x_.data(),
           has_before_ ? v_before_.data() : v_.data(),
           rest_.data(),
           mass_.data(),
           potential().pinned(),
           scheme_,
           {}};
  for (size_t d = 0; d < 3; ++d) m.gravity[d] = scene_.gravity[d];
  return m;
}

void StepOnDevice::begin_step(const StepScheme& scheme, double time) {
  scheme_ = scheme;
  const Motion m = motion();
  double *inertia = potential().inertia(), *predictor = potential().predictor(),
         *now = potential().now(), *u = quasi_.u();
  cuda::for_each(size() / 3, [=] __device__(int64_t n) {
    inertia[n] = m.scheme.a0 * m.mass[n] / (m.scheme.dt * m.scheme.dt);
    for (int d = 0; d < 3; ++d) {
      const int64_t k = 3 * n + d;
      const double away = m.x[k] - m.rest[k];
      const double way = m.pinned[n] ? 0
                                     : predicted_motion(m.scheme, m.x[k], m.v[k], m.x_before[k],
                                                        m.v_before[k], m.gravity[d]);
      now[k] = away;
      predictor[k] = u[k] = away + way;
    }
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

double StepOnDevice::reach() {
  const double* x = x_.data();
  StepNumbers* to = numbers_.data();
  ordered_sum(
      size(), largest_.data(), [=] __device__(int64_t k, Largest & sum) { sum.add({fabs(x[k])}); },
      [=] __device__(const Largest& sum) { to->reach = sum.value; });
  synchronise();
  return numbers_[0].reach;
}

/// Its gradient is of no use; positions of the next state are not there yet.
double StepOnDevice::phi_at(const double* u) {
  return potential().evaluate<double>(u, x_next_.data()).total();
}

/// x_next = X + u on the free nodes, the present x on the others; u = x_next - X.
void StepOnDevice::round_positions() {
  const Motion m = motion();
  double *u = quasi_.u(), *x_next = x_next_.data();
  cuda::for_each(size(), [=] __device__(int64_t k) {
    const double place = m.pinned[k / 3] ? m.x[k] : m.rest[k] + u[k];
    x_next[k] = place;
    u[k] = place - m.rest[k];
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

/// Solver::Impl::balance: whether free pieces got the mean motion of their predictor.
bool StepOnDevice::balance() {
  if (touches()) return false;
  const double* aim = potential().predictor();
  if (potential().contact()) copy(quasi_.u(), quasi_.trial_u());
  pieces_.match_means(mass_.data(), quasi_.u(), [=] __device__(int64_t k) { return aim[k]; });
  if (!touches()) return true;
  copy(quasi_.trial_u(), quasi_.u());
  return false;
}

Certificate StepOnDevice::certify(bool may_fly) {
  const bool in_flight = may_fly && balance();
  const double* u = quasi_.u();
  round_positions();
  potential().start_residual(u, gradient_.data());
  const double* g = gradient_.data();
  StepNumbers* to = numbers_.data();
  ordered_sum(
      size(), pair_sums_.data(),
      [=] __device__(int64_t k, Sums<2> & sum) {
        sum.value[0] += g[k] * g[k];
        sum.value[1] += isfinite(u[k]) ? 0 : 1;
      },
      [=] __device__(const Sums<2>& sum) {
        to->square = sum.value[0], to->not_finite = sum.value[1];
      });
  synchronise();
  Certificate result{potential().value(), std::sqrt(numbers_[0].square), false, in_flight};
  result.finite = std::isfinite(result.value.total()) && std::isfinite(result.size) &&
                  numbers_[0].not_finite == 0;
  return result;
}

/// v_next; pinned nodes rest.
void StepOnDevice::find_velocities() {
  const Motion m = motion();
  const double* x_next = x_next_.data();
  double* v_next = v_next_.data();
  cuda::for_each(size(), [=] __device__(int64_t k) {
    v_next[k] = m.pinned[k / 3] ? 0 : velocity_after(m.scheme, x_next[k], m.x[k], m.x_before[k]);
  });
}

void StepOnDevice::find_energies() {
  const Motion m = motion();
  const double *x_next = x_next_.data(), *v_next = v_next_.data();
  StepNumbers* to = numbers_.data();
  ordered_sum(
      size() / 3, pair_sums_.data(),
      [=] __device__(int64_t n, Sums<2> & sum) {
        for (int d = 0; d < 3; ++d) {
          const double v = v_next[3 * n + d];
          sum.value[0] += m.mass[n] / 2 * v * v;
          sum.value[1] -= m.mass[n] * m.gravity[d] * x_next[3 * n + d];
        }
      },
      [=] __device__(const Sums<2>& sum) {
        to->energy.kinetic = sum.value[0], to->energy.gravity = sum.value[1];
      });
}

/// In flight velocities lose what the rounding of positions brings into their mean.
MotionEnergy StepOnDevice::finish(bool in_flight) {
  find_velocities();
  if (in_flight) {
    const Motion m = motion();
    pieces_.match_means(mass_.data(), v_next_.data(), [=] __device__(int64_t k) {
      return free_velocity(m.scheme, m.v[k], m.v_before[k], m.gravity[k % 3]);
    });
  }
  find_energies();
  synchronise();
  std::swap(x_before_, x_);
  std::swap(x_, x_next_);
  std::swap(v_before_, v_);
  std::swap(v_, v_next_);
  has_before_ = true;
  return numbers_[0].energy;
}

/// What a step is made of.
struct Recipe {
  const IncrementalPotential& potential;
  const Preconditioner<float>* first;
  const PaperLoops* paper;

  std::unique_ptr<StepOnDevice> make() const {
    return std::make_unique<StepOnDevice>(potential, first, paper);
  }
};

}  // namespace

std::unique_ptr<DeviceStep> make_device_step(const IncrementalPotential& potential,
                                             const Preconditioner<float>& first) {
  return within_budget(Recipe{potential, &first, nullptr});
}

std::unique_ptr<DeviceStep> make_device_step(const IncrementalPotential& potential,
                                             const PaperLoops& loops) {
  return within_budget(Recipe{potential, nullptr, &loops});
}

}  // namespace elastogen::cuda
