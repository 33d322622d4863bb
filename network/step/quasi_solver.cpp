// SPDX-License-Identifier: Apache-2.0
#include "network/step/quasi_solver.hpp"

#include "network/step/quasi_loop.hpp"

namespace elastogen {

template <class T>
QuasiSolver<T>::QuasiSolver(IncrementalPotential& potential)
    : potential_(potential),
      size_(3 * potential.scene().grid.node_count()),
      trial_u_(size_t(size_)),
      gradient_(size_t(size_)),
      trial_gradient_(size_t(size_)),
      direction_(size_t(size_)),
      scratch_(size_t(size_)),
      history_(size_) {}

/// QuasiWork of the host: the trial is u - share H g, H g in direction_.
template <class T>
template <class P>
struct QuasiSolver<T>::Work {
  using Real = T;

  double begin(PotentialValue& value) {
    value = of.potential_.template evaluate<T>(u, of.gradient_.data());
    return norm(of.gradient_.data(), of.size_);
  }

  bool find_step(const PotentialValue&) {
    if (of.potential_.contact().exists()) {
      of.potential_.linearise_contact(u);
      first.update_contact();
    }
    of.history_.direction(of.gradient_.data(), of.scratch_.data(), of.direction_.data(),
                          [&](const T* q, T* d) { first.apply(q, d); });
    trial.slope_start = -dot(of.gradient_.data(), of.direction_.data(), of.size_);
    return trial.slope_start < 0;
  }

  void move(double share, bool is_first) {
    const auto place = [&](double a) {
      for_each(of.size_, [&](int64_t k) {
        of.trial_u_[size_t(k)] = u[k] - a * double(of.direction_[size_t(k)]);
      });
      of.potential_.held().follow(of.trial_u_.data());
    };
    place(share);
    trial.share = share;
    if (!is_first || !of.potential_.contact().exists()) return;
    trial.share = of.potential_.contact().longest_step(u, of.trial_u_.data());
    if (trial.share < 1) place(trial.share);
  }

  void start_trial() {
    trial.value = of.potential_.template evaluate<T>(of.trial_u_.data(), of.trial_gradient_.data());
    trial.slope_end = -trial.share * dot(of.trial_gradient_.data(), of.direction_.data(), of.size_);
  }
  TrialNumbers wait() const { return trial; }

  double accept() {
    T *s = of.history_.next_s(), *y = of.history_.next_y();
    for_each(of.size_, [&](int64_t k) {
      s[k] = T(of.trial_u_[size_t(k)] - u[k]);
      y[k] = of.trial_gradient_[size_t(k)] - of.gradient_[size_t(k)];
      u[k] = of.trial_u_[size_t(k)];
    });
    of.history_.keep();
    of.gradient_.swap(of.trial_gradient_);
    return norm(of.gradient_.data(), of.size_);
  }

  int pair_count() const { return of.history_.count(); }
  void clear() { of.history_.clear(); }
  const PotentialTerms& terms() const { return of.potential_; }

  QuasiSolver& of;
  double* u;
  Preconditioner<P>& first;
  TrialNumbers trial = {};
};

template <class T>
template <class P>
IterationResult QuasiSolver<T>::solve(double* u, double target, int max_outer,
                                      Preconditioner<P>& first, const Interrupted& interrupted) {
  history_.clear();
  Work<P> work{*this, u, first};
  return quasi_loop(work, target, max_outer, interrupted);
}

template class QuasiSolver<float>;
template class QuasiSolver<double>;
#define ELASTOGEN_INSTANTIATE(T, P) \
  template IterationResult QuasiSolver<T>::solve(double*, double, int, Preconditioner<P>&, \
                                                 const Interrupted&);
ELASTOGEN_INSTANTIATE(float, float)
ELASTOGEN_INSTANTIATE(double, float)
ELASTOGEN_INSTANTIATE(double, double)
#undef ELASTOGEN_INSTANTIATE

}  // namespace elastogen
