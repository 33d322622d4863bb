// SPDX-License-Identifier: Apache-2.0
#include "bench/measure.hpp"

#include "io/report_file.hpp"

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <vector>

namespace elastogen::bench {

double rms(const Scene& scene, const Array<double>& a, const Array<double>& b) {
  double sum = 0, mass = 0;
  for (int64_t n = 0; n < a.rows(); ++n) {
    mass += scene.mass(n);
    for (int d = 0; d < 3; ++d) sum += scene.mass(n) * std::pow(a(n, d) - b(n, d), 2);
  }
  return std::sqrt(sum / mass);
}

Timing time_step(const Scene& scene, const State& start, const SolverOptions& options, int repeats,
                 const Array<double>& reference) {
  const auto begin = std::chrono::steady_clock::now();
  Solver solver(scene, options);
  Timing timing;
  timing.setup_seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  std::vector<double> ms;
  for (int k = 0; k <= repeats; ++k) {
    State state;
    solver.begin(start);
    timing.report = solver.advance();
    solver.read(state, StateParts::kPositions);
    if (k > 0) ms.push_back(timing.report.ms);
    timing.error = rms(scene, state.x, reference) / rms(scene, start.x, reference);
  }
  timing.ms = quantile(ms, 0.5);
  return timing;
}

Reference make_reference(const Scene& scene, const StartMotion& motion, int steps_before) {
  Solver exact(scene, {.mode = SolverMode::kNewton, .tolerance = 1e-10});
  Reference reference;
  reference.start = initial_state(scene, motion);
  for (int k = 0; k < steps_before; ++k) exact.step(reference.start);
  reference.next = reference.start;
  const StepReport certificate = exact.step(reference.next);
  if (certificate.residual > 1e-9) fmt::print("reference at {:.1e} only\n", certificate.residual);
  return reference;
}

}  // namespace elastogen::bench
