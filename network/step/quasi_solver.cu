// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/held_nodes.cuh"
#include "network/step/quasi_iteration.cuh"
#include "network/step/quasi_loop.hpp"
#include "network/step/quasi_solver_device.hpp"

#include <cmath>
#include <optional>

namespace elastogen::cuda {

struct DeviceQuasi::Impl {
  explicit Impl(const PotentialTerms& terms)
      : potential(terms), u(3 * potential.nodes()), trial_u(u.size()) {}

  template <class T>
  Iteration<T>& iteration();
  template <class T>
  IterationResult solve(double target, int max_outer, const Interrupted& interrupted,
                        bool keeps_pairs = false);
  DevicePotential potential;
  std::optional<DevicePreconditioner> first;
  DeviceArray<double> u, trial_u;
  std::optional<Pairs> pairs;
  std::optional<Iteration<float>> single;
  std::optional<Iteration<double>> precise;
};

template <class T>
Iteration<T>& DeviceQuasi::Impl::iteration() {
  if (!pairs) pairs.emplace(u.size());
  const auto made = [&](auto& of) -> auto& {
    return of ? *of : of.emplace(u.size(), *pairs);
  };
  if constexpr (sizeof(T) == 4)
    return made(single);
  else
    return made(precise);
}

/// QuasiWork of the card: the trial is u + p, and p is halved with the share. A kernel that
/// measures the trial gives the slope at the start of the step as well, so that nobody waits for it
/// before. p of dependent nodes, where gradients are 0, does not count: the trial gets theirs.
template <class T>
struct QuasiWorkOfCard {
  using Real = T;

  double begin(PotentialValue& value) {
    of.potential.template start_evaluation<T>(of.u.data(), it.gradient.data());
    it.measure_gradient();
    it.signal.wait();
    it.take_gradient();
    value = of.potential.value();
    return std::sqrt(it.numbers[0].gradient);
  }

  bool find_step(const PotentialValue& value) {
    of.first->update_contact(of.u.data(), value.contact != 0);
    it.find_step(*of.first, of.u.data(), of.trial_u.data());
    return true;
  }

  void move(double share, bool is_first) {
    trial.share = share;
    is_cut = is_first && of.potential.contact();
    if (!is_first) it.halve_step(of.u.data(), of.trial_u.data());
    follow();
    if (!is_cut) return;
    of.potential.contact()->cut_step(of.u.data(), of.trial_u.data());
    follow();
    it.take_cut_step(of.u.data(), of.trial_u.data());
  }

  void follow() { of.potential.held().follow(of.trial_u.data()); }

  void start_trial() {
    of.potential.template start_gradient<T>(of.trial_u.data(), it.trial_gradient.data());
    it.measure_trial(of.trial_u.data(), of.potential.inertia_terms());
  }

  TrialNumbers wait() {
    it.signal.wait();
    if (is_cut) trial.share = of.potential.contact()->share();
    trial.value = of.potential.value();
    trial.slope_start = it.numbers[0].slope;
    trial.slope_end = it.numbers[0].trial_slope;
    return trial;
  }

  double accept() {
    const double residual = std::sqrt(it.numbers[0].gradient);
    it.accept();
    std::swap(of.u, of.trial_u);
    return residual;
  }

  int pair_count() const { return it.pairs.products.count; }
  void clear() { it.clear(); }
  const PotentialTerms& terms() const { return of.potential.terms(); }

  DeviceQuasi::Impl& of;
  Iteration<T>& it;
  TrialNumbers trial = {};
  bool is_cut = false;
};

/// @param keeps_pairs  it goes on from another precision.
template <class T>
IterationResult DeviceQuasi::Impl::solve(double target, int max_outer,
                                         const Interrupted& interrupted, bool keeps_pairs) {
  QuasiWorkOfCard<T> work{*this, iteration<T>()};
  if (!keeps_pairs) work.clear();
  return quasi_loop(work, target, max_outer, interrupted);
}

DeviceQuasi::DeviceQuasi(const PotentialTerms& terms, const EncoderChoice& encoder)
    : DeviceQuasi(terms) {
  impl_->first.emplace(impl_->potential, encoder);
}

DeviceQuasi::DeviceQuasi(const PotentialTerms& terms) : impl_(std::make_unique<Impl>(terms)) {}

DeviceQuasi::~DeviceQuasi() = default;

size_t DeviceQuasi::later_bytes(int64_t nodes) {
  // of pairs and iterations; they are made when they come first
  constexpr size_t kPairBytes = 2 * kPairs * sizeof(PairNumber) + sizeof(float);
  return 3 * size_t(nodes) * (kPairBytes + 2 * sizeof(float) + 2 * sizeof(double)) +
         2 * (sizeof(SumScratch<Sums<kPairs + 1>>) + sizeof(SumScratch<Sums<kGradientSums>>) +
              sizeof(SumScratch<Sums<kTrialSums>>));
}

DevicePotential& DeviceQuasi::potential() {
  return impl_->potential;
}

DevicePreconditioner& DeviceQuasi::preconditioner() {
  return *impl_->first;
}

double* DeviceQuasi::u() {
  return impl_->u.data();
}

double* DeviceQuasi::trial_u() {
  return impl_->trial_u.data();
}

DeviceArray<double>& DeviceQuasi::trial() {
  return impl_->trial_u;
}

void DeviceQuasi::accept_trial() {
  std::swap(impl_->u, impl_->trial_u);
}

void DeviceQuasi::set_nodal_rotations() {
  impl_->potential.set_nodal_rotations(impl_->u.data());
}

IterationResult DeviceQuasi::solve(double target, int max_outer, double precise_below,
                                   const Interrupted& interrupted) {
  if (precise_below <= target) return impl_->solve<float>(target, max_outer, interrupted);
  if (!std::isfinite(precise_below)) return impl_->solve<double>(target, max_outer, interrupted);
  const IterationResult in_float = impl_->solve<float>(precise_below, max_outer, interrupted);
  return sum(in_float, impl_->solve<double>(target, max_outer - in_float.outer, interrupted,
                                            in_float.converged));
}

void DeviceQuasi::begin_step(const IncrementalPotential& host) {
  impl_->potential.begin_step(host);
}

void DeviceQuasi::download_u(double* u) {
  impl_->u.download(u);
}

void DeviceQuasi::update_contact(bool touching) {
  impl_->first->update_contact(impl_->u.data(), touching);
}

void DeviceQuasi::set_nodal_rotations(const double* u) {
  impl_->u.upload(u);
  set_nodal_rotations();
}

IterationResult DeviceQuasi::solve(double* u, double target, int max_outer, double precise_below,
                                   const Interrupted& interrupted) {
  impl_->u.upload(u);
  const IterationResult result = solve(target, max_outer, precise_below, interrupted);
  impl_->u.download(u);
  return result;
}

template <class T>
void DeviceQuasi::precondition(const T* r, T* z) {
  DevicePreconditioner& first = *impl_->first;
  first.turn([=] __device__(int64_t n, float v[3]) {
    for (int i = 0; i < 3; ++i) v[i] = float(r[3 * n + i]);
  });
  first.cycle();
  const UnturnedResult result = first.result();
  cuda::for_each(impl_->potential.nodes(), [=] __device__(int64_t n) { result.at(n, z + 3 * n); });
  impl_->potential.held().fill(z);
}

template void DeviceQuasi::precondition(const float*, float*);
template void DeviceQuasi::precondition(const double*, double*);

}  // namespace elastogen::cuda
