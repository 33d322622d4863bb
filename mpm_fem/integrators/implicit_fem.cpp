// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/implicit_fem.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"
#include "core/stopwatch.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {
namespace {

void check_state_array(const Array<double>& array, int64_t nodes, const char* name) {
  ELASTOGEN_CHECK(array.rows() == nodes && array.cols() == 3, "state.", name,
                  " must be (nodes, 3) with ", nodes, " nodes, got (", array.rows(), ", ",
                  array.cols(), ")");
}

void check_state(const FemState& state, int64_t nodes) {
  check_state_array(state.u, nodes, "u");
  check_state_array(state.v, nodes, "v");
  ELASTOGEN_CHECK(state.u_before.empty() == state.v_before.empty(),
                  "state.u_before and state.v_before must both be given or both be empty");
  if (!state.a.empty()) check_state_array(state.a, nodes, "a");
  if (state.u_before.empty()) return;
  check_state_array(state.u_before, nodes, "u_before");
  check_state_array(state.v_before, nodes, "v_before");
}

constexpr double kLoose = 1e-2;  // residual at which a collider may go on

bool all_finite(const Array<double>& values) {
  return std::all_of(values.data(), values.data() + values.size(),
                     [](double v) { return std::isfinite(v); });
}

}  // namespace

ImplicitFem::ImplicitFem(const FemScene& scene, const ImplicitOptions& options)
    : scene_(scene),
      options_(options),
      terms_(scene, options.linear),
      potential_(terms_.potential),
      reference_(reference_force(scene, potential_.mass().nodal())),
      predictor_(scene.mesh.rest.rows(), 3),
      gradient_(predictor_),
      weight_(predictor_) {
  ELASTOGEN_CHECK(options.tolerance > 0, "the tolerance must be positive, got ", options.tolerance);
  ELASTOGEN_CHECK(scene.dt > 0 && std::isfinite(scene.dt), "dt must be positive, got ", scene.dt);
  Array<double> gravity(weight_.rows(), 3);
  for (int64_t k = 0; k < gravity.size(); ++k) gravity.data()[k] = scene.gravity[size_t(k % 3)];
  potential_.mass().multiply(gravity.data(), weight_.data());
}

StepScheme ImplicitFem::scheme_of(const FemState& state) const {
  if (scene_.scheme == Scheme::kNewmark) return {TimeScheme::kEuler, period_.dt, 4};
  if (scene_.scheme == Scheme::kBdf2 && !state.u_before.empty())
    return {TimeScheme::kBdf2, period_.dt, 2.25};
  return {TimeScheme::kEuler, period_.dt, 1};
}

/// Sets the potential of the step.
void ImplicitFem::begin(FemState& state) {
  scheme_ = scheme_of(state);
  terms_.freeze_rotations(state.u);
  // materials that yield start from the history of the state
  if (terms_.plastic) {
    PlasticBody& body = terms_.plastic->body();
    body.set_history(state.plastic.memory.empty() ? body.rest_history() : state.plastic);
  }
  const double dt = period_.dt;
  const bool newmark = scene_.scheme == Scheme::kNewmark;
  if (newmark && state.a.empty()) start_newmark(state);
  // forces and contact of the step
  Array<double> force = applied_force(scene_, period_.end, 1);
  if (terms_.contact.exists())
    terms_.contact.begin_step(state.u, period_.start, dt, dt / scene_.dt);
  // predictor; Newmark has gravity in the forces
  const bool history = !state.u_before.empty();
  for (int64_t k = 0; k < predictor_.size(); ++k) {
    const double u = state.u.data()[k], v = state.v.data()[k];
    double motion;
    if (newmark) {
      motion = dt * v + dt * dt / 4 * state.a.data()[k];
      force.data()[k] += weight_.data()[k];
    } else {
      motion =
          predicted_motion(scheme_, u, v, history ? state.u_before.data()[k] : u,
                           history ? state.v_before.data()[k] : 0, scene_.gravity[size_t(k % 3)]);
    }
    predictor_.data()[k] = u + motion;
  }
  potential_.set_force(force);
  potential_.set_inertia(scheme_.a0 / (dt * dt), predictor_);
}

/// Accelerations of the free components from the equation of motion; 0 of the others.
void ImplicitFem::start_newmark(FemState& state) {
  Array<double> force = applied_force(scene_, state.time, 1);
  for (int64_t k = 0; k < force.size(); ++k) force.data()[k] += weight_.data()[k];
  potential_.set_force(force);
  potential_.set_inertia(0, predictor_);
  state.a = Array<double>(state.u.rows(), 3);
  potential_.full_gradient(state.u.data(), gradient_.data());
  std::vector<uint8_t> fixed(size_t(state.u.size()));
  for (int64_t k = 0; k < state.u.size(); ++k) {
    fixed[size_t(k)] = potential_.is_fixed(k);
    state.a.data()[k] = fixed[size_t(k)] ? 0 : -gradient_.data()[k];
  }
  SparseMatrix M = potential_.hessian();
  std::fill(M.value.begin(), M.value.end(), 0.0);
  potential_.mass().add_to(1, M);
  fix_unknowns(fixed.data(), M, nullptr);
  LinearSolver solver(M, scene_.mesh.rest, fixed.data(), options_.linear);
  solver.factor(M);
  const std::vector<double> right(state.a.data(), state.a.data() + state.a.size());
  solver.solve(right.data(), state.a.data(), 1e-14);
}

/// The predictor or the present state, whichever has the lower potential, with the fixed components
/// moved.
Array<double> ImplicitFem::start_value(const FemState& state) {
  Array<double> ahead = predictor_;
  for (int64_t k = 0; k < ahead.size(); ++k)
    if (potential_.is_fixed(k)) ahead.data()[k] = state.u.data()[k];
  const double here = potential_.evaluate(state.u.data(), gradient_.data()).value;
  const double there = potential_.evaluate(ahead.data(), gradient_.data()).value;
  Array<double> u = there < here ? std::move(ahead) : state.u;
  potential_.move_fixed(with_motion(scene_, period_.end, u), u.data());
  return u;
}

/// Moves the colliders through the step share by share where they would run into u, and lets u give
/// way to each share. False: they leave it no space.
bool ImplicitFem::pass_colliders(Array<double>& u) {
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

/// Finds the residual of the equations and the energies for the state that is returned.
void ImplicitFem::certify(const Array<double>& u, FemStepReport& report) {
  if (terms_.plastic) terms_.plastic->body().thaw();
  const NewtonValue value = potential_.evaluate(u.data(), gradient_.data());
  const double size = norm(gradient_.data(), gradient_.size());
  report.residual = reference_ > 0 ? size / reference_ : 0;
  report.converged = report.residual <= options_.tolerance;
  report.finite = std::isfinite(value.value) && std::isfinite(size) && all_finite(u);
  report.energy = terms_.energy(u);
  if (terms_.contact.exists()) {
    report.energy.contact = terms_.contact.energy(u);
    report.deepest_overlap = terms_.contact.deepest_overlap(u) / terms_.length();
  }
  report.min_j = terms_.min_j(u);
}

/// The displacements that the state gets for u.
Array<double> ImplicitFem::handed_out(const Array<double>& u) const {
  Array<double> handed = u;
  if (!options_.as_positions) return handed;
  for (int64_t k = 0; k < u.size(); ++k) {
    const double rest = scene_.mesh.rest.data()[k], x = rest + u.data()[k];
    handed.data()[k] = x - rest;
  }
  return handed;
}

/// Writes displacements, velocities and accelerations to the state.
/// @param u  the minimum, from which velocities and accelerations follow.
void ImplicitFem::finish(const Array<double>& u, Array<double> handed, FemState& state,
                         FemStepReport& report) {
  const double dt = period_.dt;
  Array<double> v(u.rows(), 3), Mv(u.rows(), 3);
  // velocities and accelerations by the scheme, and the energy of gravity
  for (int64_t k = 0; k < u.size(); ++k) {
    const double before = state.u_before.empty() ? state.u.data()[k] : state.u_before.data()[k];
    if (scene_.scheme == Scheme::kNewmark) {
      const double a = 4 / (dt * dt) * (u.data()[k] - predictor_.data()[k]);
      v.data()[k] = state.v.data()[k] + dt / 2 * (state.a.data()[k] + a);
      state.a.data()[k] = a;
    } else {
      v.data()[k] = velocity_after(scheme_, u.data()[k], state.u.data()[k], before);
    }
    const double x = scene_.mesh.rest.data()[k] + u.data()[k];
    report.energy.gravity -= weight_.data()[k] * x;
  }
  // kinetic energy, and the flow of the step
  potential_.mass().multiply(v.data(), Mv.data());
  report.energy.kinetic = dot(v.data(), Mv.data(), v.size()) / 2;
  if (terms_.plastic) {
    state.plastic = terms_.plastic->body().history_after(handed);
    report.energy.plastic = state.plastic_work += report.energy.plastic;
  }
  // the state moves on by a step
  state.u_before = std::move(state.u);
  state.v_before = std::move(state.v);
  state.u = std::move(handed);
  state.v = std::move(v);
  state.time = period_.end;
}

FemStepReport ImplicitFem::step(FemState& state) {
  const double dt = scene_.dt, steps = double(state.steps);
  FemStepReport report = advance(state, {steps * dt, (steps + 1) * dt, dt});
  if (report.finite) ++state.steps;
  return report;
}

FemStepReport ImplicitFem::step_part(FemState& state, double part) {
  ELASTOGEN_CHECK(part > 0 && part <= scene_.dt, "a part must lie in (0, ", scene_.dt, "] s, got ",
                  part);
  return advance(state, {state.time, state.time + part, part});
}

FemStepReport ImplicitFem::advance(FemState& state, const Period& period) {
  const Stopwatch watch;
  check_state(state, scene_.mesh.rest.rows());
  period_ = period;
  const int64_t inner = potential_.solver().iterations() + potential_.root_iterations();
  begin(state);
  FemStepReport report;
  report.step = state.steps + 1;
  report.time = period.end;
  report.scheme = scheme_.scheme;
  report.used = scheme_.scheme == TimeScheme::kBdf2 ? Scheme::kBdf2 : Scheme::kEuler;
  if (scene_.scheme == Scheme::kNewmark) report.used = Scheme::kNewmark;
  report.float64 = true;

  // materials without a potential begin with a frozen one
  if (terms_.plastic) terms_.plastic->body().freeze(state.u);
  Array<double> u = start_value(state);
  const bool clear = pass_colliders(u);
  const Equilibrium newton = find_equilibrium(
      terms_, {.tolerance = options_.tolerance * reference_, .max_iterations = options_.max_newton},
      u.data());
  report.outer = newton.iterations;
  report.inner = int(potential_.solver().iterations() + potential_.root_iterations() - inner);
  report.fallbacks = newton.fallbacks;
  report.yields = terms_.plastic != nullptr;
  report.stop = newton.stop;
  report.floor = reference_ > 0 ? newton.noise / reference_ : 0;
  Array<double> handed = handed_out(u);
  certify(handed, report);
  if (!clear) report.finite = false, report.refusal = "a collider leaves the body no room";
  if (report.finite) finish(u, std::move(handed), state, report);
  report.ms = watch.milliseconds();
  return report;
}

}  // namespace elastogen::fem
