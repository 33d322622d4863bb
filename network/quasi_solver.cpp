// SPDX-License-Identifier: Apache-2.0
#include "network/quasi_solver.hpp"

#include "core/line_search.hpp"

#include <limits>

namespace elastogen {

namespace {

constexpr int kPatience = 25;  // iterations

}  // namespace

template <class T>
QuasiSolver<T>::QuasiSolver(IncrementalPotential& potential)
    : potential_(potential),
      size_(3 * potential.scene().grid.node_count()),
      trial_u_(size_t(size_)),
      gradient_(size_t(size_)),
      trial_gradient_(size_t(size_)),
      direction_(size_t(size_)),
      work_(size_t(size_)),
      history_(size_) {}

/// Halves the step against direction_ until Phi falls; trial_u_, trial_gradient_ and value are
/// there then. False: it never did.
template <class T>
bool QuasiSolver<T>::line_search(const double* u, double slope, PotentialValue& value,
                                 int& evaluations) {
  if (!(slope < 0)) return false;
  const double noise = potential_.noise(value, std::numeric_limits<T>::epsilon());
  const auto move = [&](double a) {
    for_each(size_,
             [&](int64_t k) { trial_u_[size_t(k)] = u[k] - a * double(direction_[size_t(k)]); });
  };
  PotentialValue there;
  const auto trial = [&](double a, int halvings) {
    move(a);
    if (halvings == 0 && potential_.contact().exists()) {
      a = potential_.contact().longest_step(u, trial_u_.data());
      if (a < 1) move(a);
    }
    there = potential_.evaluate<T>(trial_u_.data(), trial_gradient_.data());
    ++evaluations;
    return LineTrial{.share = a,
                     .difference = there.total() - value.total(),
                     .slope_start = slope,
                     .slope_end = -a * dot(trial_gradient_.data(), direction_.data(), size_),
                     .noise = noise};
  };
  if (!backtrack(trial)) return false;
  value = there;
  return true;
}

template <class T>
template <class P>
IterationResult QuasiSolver<T>::solve(double* u, double target, int max_outer,
                                      Preconditioner<P>& first,
                                      const std::function<bool()>& interrupted) {
  IterationResult result;
  history_.clear();
  PotentialValue value = potential_.evaluate<T>(u, gradient_.data());
  result.inner = 1;
  int halved_at = 0;
  double half = 1e300;
  while (true) {
    const double residual = norm(gradient_.data(), size_);
    if (residual < half) half = residual / 2, halved_at = result.outer;
    const bool stalled = sizeof(T) == 4 && result.outer - halved_at > kPatience;
    result.converged = residual <= target;
    if (result.converged || stalled || result.outer == max_outer || interrupted()) return result;
    if (potential_.contact().exists()) {
      potential_.linearise_contact(u);
      first.update_contact();
    }
    history_.direction(gradient_.data(), work_.data(), direction_.data(),
                       [&](const T* q, T* d) { first.apply(q, d); });
    const double slope = -dot(gradient_.data(), direction_.data(), size_);
    if (!line_search(u, slope, value, result.inner)) {
      if (history_.count() == 0) return result;
      history_.clear();
      continue;
    }
    T* s = history_.next_s();
    T* y = history_.next_y();
    for_each(size_, [&](int64_t k) {
      s[k] = T(trial_u_[size_t(k)] - u[k]);
      y[k] = trial_gradient_[size_t(k)] - gradient_[size_t(k)];
      u[k] = trial_u_[size_t(k)];
    });
    history_.keep();
    gradient_.swap(trial_gradient_);
    ++result.outer;
  }
}

template class QuasiSolver<float>;
template class QuasiSolver<double>;
#define ELASTOGEN_INSTANTIATE(T, P) \
  template IterationResult QuasiSolver<T>::solve(double*, double, int, Preconditioner<P>&, \
                                                 const std::function<bool()>&);
ELASTOGEN_INSTANTIATE(float, float)
ELASTOGEN_INSTANTIATE(double, float)
ELASTOGEN_INSTANTIATE(double, double)
#undef ELASTOGEN_INSTANTIATE

}  // namespace elastogen
