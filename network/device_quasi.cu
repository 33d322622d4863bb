// SPDX-License-Identifier: Apache-2.0
#include "core/line_search.hpp"
#include "network/device_iteration.cuh"
#include "network/device_quasi.hpp"

#include <cmath>
#include <limits>
#include <optional>

namespace elastogen::cuda {
namespace {

constexpr int kPatience = 25;  // iterations, as on the CPU

}  // namespace

struct DeviceQuasi::Impl {
  explicit Impl(const PotentialTerms& terms)
      : potential(terms), u(3 * potential.nodes()), trial_u(u.size()) {}

  template <class T>
  Iteration<T>& iteration();
  template <class T>
  IterationResult solve(double target, int max_outer, const std::function<bool()>& interrupted,
                        bool keeps_pairs = false);
  template <class T>
  bool line_search(Iteration<T>& it, PotentialValue& value, int& evaluations);
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

/// Halves the step until Phi falls; the first trial is there.
template <class T>
bool DeviceQuasi::Impl::line_search(Iteration<T>& it, PotentialValue& value, int& evaluations) {
  const double noise = potential.terms().noise(value, std::numeric_limits<T>::epsilon());
  DeviceContact* contact = potential.contact();
  if (contact) {
    contact->cut_step(u.data(), trial_u.data());
    it.take_cut_step(u.data(), trial_u.data());
  }
  PotentialValue there;
  const auto trial = [&](double a, int halvings) {
    if (halvings > 0) it.halve_step(u.data(), trial_u.data());
    potential.start_gradient<T>(trial_u.data(), it.trial_gradient.data());
    it.measure_trial(trial_u.data(), potential.inertia_terms());
    it.signal.wait();
    if (contact && halvings == 0) a = contact->share();
    ++evaluations;
    there = potential.value();
    return LineTrial{.share = a,
                     .difference = there.total() - value.total(),
                     .slope_start = it.numbers[0].slope,
                     .slope_end = it.numbers[0].trial_slope,
                     .noise = noise};
  };
  if (!backtrack(trial)) return false;
  value = there;
  return true;
}

/// @param keeps_pairs  it goes on from another precision.
template <class T>
IterationResult DeviceQuasi::Impl::solve(double target, int max_outer,
                                         const std::function<bool()>& interrupted,
                                         bool keeps_pairs) {
  Iteration<T>& it = iteration<T>();
  if (!keeps_pairs) it.clear();
  IterationResult result;
  potential.start_evaluation<T>(u.data(), it.gradient.data());
  it.measure_gradient();
  it.signal.wait();
  it.take_gradient();
  PotentialValue value = potential.value();
  result.inner = 1;
  double residual = std::sqrt(it.numbers[0].gradient), half = 1e300;
  int halved_at = 0;
  while (true) {
    if (residual < half) half = residual / 2, halved_at = result.outer;
    const bool stalled = sizeof(T) == 4 && result.outer - halved_at > kPatience;
    result.converged = residual <= target;
    if (result.converged || stalled || result.outer == max_outer || interrupted()) return result;
    first->update_contact(u.data(), value.contact != 0);
    it.find_step(*first, u.data(), trial_u.data());
    if (!line_search(it, value, result.inner)) {
      if (it.pairs.products.count == 0) return result;
      it.clear();
      continue;
    }
    residual = std::sqrt(it.numbers[0].gradient);
    it.accept();
    std::swap(u, trial_u);
    ++result.outer;
  }
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
         2 * (sizeof(SumRoom<Sums<kPairs + 1>>) + sizeof(SumRoom<Sums<kGradientSums>>) +
              sizeof(SumRoom<Sums<kTrialSums>>));
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
                                   const std::function<bool()>& interrupted) {
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
                                   const std::function<bool()>& interrupted) {
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
}

template void DeviceQuasi::precondition(const float*, float*);
template void DeviceQuasi::precondition(const double*, double*);

}  // namespace elastogen::cuda
