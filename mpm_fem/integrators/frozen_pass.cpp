// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/frozen_pass.hpp"

namespace elastogen::mpm {

/// step = -H^-1 gradient; if conjugate gradients end early, their result still goes downhill.
template <int d>
bool FrozenPass<d>::find_step(const double* y, const double* gradient, TangentKind kind,
                              double tolerance, double* step) {
  const int64_t size = potential_.unknowns();
  if (int64_t(work_.r.size()) != size) work_ = PcgWork<double>(size);
  potential_.linearise(y, kind);
  const PcgResult result = pcg(
      gradient, step, size, tolerance, max_iterations_, work_,
      [&](const double* p, double* Hp) { potential_.product(p, Hp); },
      [&](const double* p, double* z) { potential_.precondition(p, z); });
  iterations_ += result.iterations;
  for (int64_t k = 0; k < size; ++k) step[k] = -step[k];
  return kind == TangentKind::kProjected || !result.end.ended;
}

template <int d>
fem::NewtonResult FrozenPass<d>::take(bool drag, const fem::NewtonOptions& options, double* y) {
  potential_.freeze(y, drag);
  potential_.meet_obstacles(y);
  fem::NewtonFunction f;
  f.unknowns = potential_.unknowns();
  f.evaluate = [&](const double* x, double* g) { return potential_.evaluate(x, g); };
  f.step = [&](const double* x, const double* g, TangentKind kind, double tolerance, double* step) {
    return find_step(x, g, kind, tolerance, step);
  };
  f.longest_step = [&](const double* x, const double* end) {
    return potential_.longest_step(x, end);
  };
  f.gradient_noise = [&](const double* x) { return potential_.noise(x); };
  const fem::NewtonResult result = fem::minimise(f, options, y);
  potential_.thaw();
  return result;
}

template class FrozenPass<2>;
template class FrozenPass<3>;

}  // namespace elastogen::mpm
