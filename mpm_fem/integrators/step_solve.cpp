// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/step_solve.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"
#include "mpm_fem/integrators/fem_state.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {
namespace {

constexpr double kLoose = 1e-2;  // residual at which a collider may go on

}  // namespace

StepSolve::StepSolve(const FemScene& scene, const ImplicitOptions& options)
    : scene_(scene),
      options_(options),
      terms_(scene, options.linear),
      potential_(terms_.potential),
      reference_(reference_force(scene, potential_.mass().nodal())),
      gradient_(scene.mesh.rest.rows(), 3),
      weight_(gradient_) {
  ELASTOGEN_CHECK(options.tolerance > 0, "the tolerance must be positive, got ", options.tolerance);
  ELASTOGEN_CHECK(scene.dt > 0 && std::isfinite(scene.dt), "dt must be positive, got ", scene.dt);
  Array<double> gravity(weight_.rows(), 3);
  for (int64_t k = 0; k < gravity.size(); ++k) gravity.data()[k] = scene.gravity[size_t(k % 3)];
  potential_.mass().multiply(gravity.data(), weight_.data());
}

int64_t StepSolve::iterations() const {
  return potential_.solver().iterations() + potential_.root_iterations();
}

Array<double> StepSolve::start_value(const Array<double>& now, std::vector<Array<double>> ahead,
                                     double time) {
  Array<double> u = now;
  double least = potential_.evaluate(u.data(), gradient_.data()).value;
  for (Array<double>& candidate : ahead) {
    potential_.carry(now.data(), candidate.data());
    const double there = potential_.evaluate(candidate.data(), gradient_.data()).value;
    if (there < least) u = std::move(candidate), least = there;
  }
  potential_.move_fixed(with_motion(scene_, time, u), u.data());
  return u;
}

bool StepSolve::pass_colliders(Array<double>& u) {
  ColliderContact& contact = terms_.contact;
  if (!contact.exists()) return true;
  double share = 0;
  contact.stand_at(share);
  while (share < 1) {
    const double next = contact.clear_share(u, share);
    if (next == share) break;
    share = next;
    contact.stand_at(share);
    if (terms_.plastic) terms_.plastic->body().freeze(u);
    if (share < 1)
      potential_.minimise({.tolerance = kLoose * reference_, .max_iterations = 20}, u.data());
  }
  contact.stand_at(1);
  return !contact.obstacle(u);
}

Array<double> StepSolve::minimise(double tolerance, Array<double>& u, FemStepReport& report) {
  const Equilibrium newton = find_equilibrium(
      terms_, {.tolerance = tolerance * reference_, .max_iterations = options_.max_newton},
      u.data());
  report.float64 = true;
  report.outer += newton.iterations;
  report.fallbacks += newton.fallbacks;
  report.yields = terms_.plastic != nullptr;
  report.stop = newton.stop;
  report.floor = reference_ > 0 ? newton.noise / reference_ : 0;
  Array<double> handed = handed_out(u);
  certify(tolerance, handed, report);
  return handed;
}

void StepSolve::certify(double tolerance, const Array<double>& u, FemStepReport& report) {
  if (terms_.plastic) terms_.plastic->body().thaw();
  const NewtonValue value = potential_.evaluate(u.data(), gradient_.data());
  const double size = norm(gradient_.data(), gradient_.size());
  report.residual = reference_ > 0 ? size / reference_ : 0;
  report.converged = report.residual <= tolerance;
  report.finite =
      std::isfinite(value.value) && std::isfinite(size) && all_finite(u.data(), u.size());
  report.energy = terms_.energy(u);
  if (terms_.contact.exists()) {
    report.energy.contact = terms_.contact.energy(u);
    report.deepest_overlap = terms_.contact.deepest_overlap(u) / terms_.length();
  }
  report.min_j = terms_.min_j(u);
}

Array<double> StepSolve::handed_out(const Array<double>& u) const {
  Array<double> handed = u;
  if (!options_.as_positions) return handed;
  const auto round = [&](int64_t k) {
    const double rest = scene_.mesh.rest.data()[k], x = rest + handed.data()[k];
    handed.data()[k] = x - rest;
  };
  for (int64_t k = 0; k < u.size(); ++k) round(k);
  // dependent nodes follow the rounded ones
  potential_.constraint().place(handed.data());
  for (int64_t i = 0; i < scene_.dependent.count(); ++i)
    for (int d = 0; d < 3; ++d) round(3 * int64_t(scene_.dependent.node(i)) + d);
  return handed;
}

}  // namespace elastogen::fem
