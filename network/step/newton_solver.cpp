// SPDX-License-Identifier: Apache-2.0
#include "network/step/newton_solver.hpp"

#include "network/step/newton_loop.hpp"

namespace elastogen {
NewtonSolver::NewtonSolver(IncrementalPotential& potential)
    : potential_(potential),
      size_(3 * potential.scene().grid.node_count()),
      trial_u_(size_t(size_)),
      gradient_(size_t(size_)),
      trial_gradient_(size_t(size_)),
      right_(size_t(size_)),
      step_(size_t(size_)),
      pcg_(size_) {}

/// NewtonWork of the host: the trial is u + share d, d in step_.
template <class P>
struct NewtonSolver::Work {
  double begin(PotentialValue& value) {
    value = of.potential_.template evaluate<double>(u, of.gradient_.data());
    return norm(of.gradient_.data(), of.size_);
  }

  void linearise(TangentKind kind, const PotentialValue&) {
    of.potential_.linearise(u, kind);
    preconditioner.update_contact();
    of.folds_.looks() ? preconditioner.update_folds(u) : preconditioner.clear_folds();
  }

  LinearResult solve(double unit, double eta, int most, const PcgScalars& scalars,
                     const Interrupted& interrupted) {
    for_each(of.size_,
             [&](int64_t k) { of.right_[size_t(k)] = float(-of.gradient_[size_t(k)] / unit); });
    const PcgResult inner = pcg(
        of.right_.data(), of.step_.data(), of.size_, eta, most, of.pcg_,
        [&](const float* p, float* Ap) { of.potential_.hessian_product(p, Ap); },
        [&](const float* r, float* z) { preconditioner.apply(r, z); }, interrupted, scalars);
    for_each(of.size_, [&](int64_t k) { of.step_[size_t(k)] *= float(unit); });
    of.folds_.take(inner.iterations, preconditioner.has_folds());
    return {inner.iterations, inner.end};
  }

  double slope() { return trial.slope_start = slope_of(of.gradient_); }

  void move(double share, bool is_first) {
    const auto place = [&](double a) {
      for_each(of.size_,
               [&](int64_t k) { of.trial_u_[size_t(k)] = u[k] + a * double(of.step_[size_t(k)]); });
      of.potential_.held().follow(of.trial_u_.data());
    };
    place(share);
    trial.share = share;
    if (!is_first || !of.potential_.contact().exists()) return;
    trial.share = of.potential_.contact().longest_step(u, of.trial_u_.data());
    if (trial.share < 1) place(trial.share);
  }

  void start_trial() {
    trial.value =
        of.potential_.template evaluate<double>(of.trial_u_.data(), of.trial_gradient_.data());
    trial.slope_end = trial.share * slope_of(of.trial_gradient_);
  }
  TrialNumbers wait() const { return trial; }

  double accept() {
    std::copy(of.trial_u_.begin(), of.trial_u_.end(), u);
    of.gradient_.swap(of.trial_gradient_);
    return norm(of.gradient_.data(), of.size_);
  }

  int64_t size() const { return of.size_; }
  const PotentialTerms& terms() const { return of.potential_; }

  double slope_of(const std::vector<double>& g) const {
    return ordered_sum(of.size_, [&](int64_t begin, int64_t end) {
      double sum = 0;
      for (int64_t k = begin; k < end; ++k) sum += g[size_t(k)] * double(of.step_[size_t(k)]);
      return sum;
    });
  }

  NewtonSolver& of;
  double* u;
  Preconditioner<P>& preconditioner;
  TrialNumbers trial = {};
};

template <class P>
IterationResult NewtonSolver::solve(double* u, double target, int max_outer, int max_inner,
                                    Preconditioner<P>& preconditioner,
                                    const Interrupted& interrupted) {
  Work<P> work{*this, u, preconditioner};
  const IterationResult result =
      newton_loop(work, region_, target, max_outer, max_inner, interrupted);
  preconditioner.clear_folds();
  return result;
}

#define ELASTOGEN_INSTANTIATE(P) \
  template IterationResult NewtonSolver::solve(double*, double, int, int, Preconditioner<P>&, \
                                               const Interrupted&);
ELASTOGEN_INSTANTIATE(float)
ELASTOGEN_INSTANTIATE(double)
#undef ELASTOGEN_INSTANTIATE

}  // namespace elastogen
