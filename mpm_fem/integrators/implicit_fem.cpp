// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/implicit_fem.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"
#include "core/stopwatch.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {

ImplicitFem::ImplicitFem(const FemScene& scene, const ImplicitOptions& options)
    : scene_(scene),
      options_(options),
      solve_(scene, options),
      terms_(solve_.terms()),
      potential_(terms_.potential),
      applied_(scene),
      predictor_(scene.mesh.rest.rows(), 3),
      holding_(predictor_) {
  ELASTOGEN_CHECK(scene.scheme != Scheme::kSdirk2 && scene.scheme != Scheme::kAuto,
                  "steps of stages are made by StageFem");
  ELASTOGEN_CHECK(scene.scheme != Scheme::kNewmark || !terms_.viscous,
                  "Newmark's scheme has no damping");
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
  terms_.move_dependent(period_.end);
  applied_.begin(period_.end, scheme_.response());
  applied_.start_wind(state.u, state.v);
  set_force();
  if (terms_.contact.exists())
    terms_.contact.begin_step(state.u, period_.start, dt, dt / scene_.dt);
  // predictor; Newmark has gravity in the forces
  const bool history = !state.u_before.empty();
  for (int64_t k = 0; k < predictor_.size(); ++k) {
    const double u = state.u.data()[k], v = state.v.data()[k];
    double motion;
    if (newmark) {
      motion = dt * v + dt * dt / 4 * state.a.data()[k];
    } else {
      motion =
          predicted_motion(scheme_, u, v, history ? state.u_before.data()[k] : u,
                           history ? state.v_before.data()[k] : 0, scene_.gravity[size_t(k % 3)]);
    }
    predictor_.data()[k] = u + motion;
  }
  potential_.set_inertia(scheme_.a0 / (dt * dt), predictor_);
  // of BDF2 E' = (3 E - 4 E_now + E_before) / (2 dt)
  terms_.begin_damping(std::sqrt(scheme_.a0) / dt, state.u,
                       scheme_.scheme == TimeScheme::kBdf2 ? -1.0 / 3 : 0, state.u_before);
}

/// Sets loads and, of Newmark's scheme, the weight, which others have in the predictor.
void ImplicitFem::set_force() {
  Array<double> force = applied_.force();
  for (int64_t k = 0; scene_.scheme == Scheme::kNewmark && k < force.size(); ++k)
    force.data()[k] += solve_.weight().data()[k];
  potential_.set_force(force);
}

/// Accelerations of the free components from the equation of motion; 0 of fixed ones, and dependent
/// nodes follow.
void ImplicitFem::start_newmark(FemState& state) {
  // forces
  applied_.begin(state.time, 0);
  applied_.start_wind(state.u, state.v);
  set_force();
  potential_.set_inertia(0, predictor_);
  state.a = Array<double>(state.u.rows(), 3);
  Array<double> gradient = predictor_;
  potential_.free_gradient(state.u.data(), gradient.data());
  std::vector<uint8_t> bound(size_t(state.u.size()));
  for (int64_t k = 0; k < state.u.size(); ++k) {
    bound[size_t(k)] = potential_.is_fixed(k);
    state.a.data()[k] = bound[size_t(k)] ? 0 : -gradient.data()[k];
  }
  const Constraint& constraint = potential_.constraint();
  constraint.mark(bound);
  // the mass of the free components
  SparseMatrix M = potential_.hessian();
  std::fill(M.value.begin(), M.value.end(), 0.0);
  potential_.mass().add_to(1, M);
  constraint.fold(M);
  fix_unknowns(bound.data(), M, nullptr);
  LinearSolver solver(M, scene_.mesh.rest, bound.data(), options_.linear);
  solver.factor(M);
  const std::vector<double> right(state.a.data(), state.a.data() + state.a.size());
  solver.solve(right.data(), state.a.data(), 1e-14);
  constraint.follow(state.a.data());
}

/// Velocities at the end of the step, where displacements are u.
Array<double> ImplicitFem::velocities(const Array<double>& u, const FemState& state) const {
  const double dt = period_.dt;
  Array<double> v(u.rows(), 3);
  for (int64_t k = 0; k < u.size(); ++k) {
    const double before = state.u_before.empty() ? state.u.data()[k] : state.u_before.data()[k];
    if (scene_.scheme == Scheme::kNewmark) {
      const double a = 4 / (dt * dt) * (u.data()[k] - predictor_.data()[k]);
      v.data()[k] = state.v.data()[k] + dt / 2 * (state.a.data()[k] + a);
    } else {
      v.data()[k] = velocity_after(scheme_, u.data()[k], state.u.data()[k], before);
    }
  }
  return v;
}

/// Moves u to the minimum. In wind, which a solve takes as given, again until the residual holds with
/// that where it ends. @return the displacements that the state gets for u
Array<double> ImplicitFem::minimise(const FemState& state, Array<double>& u,
                                    FemStepReport& report) {
  Array<double> handed = solve_.minimise(options_.tolerance, u, report);
  for (int solves = 1; report.finite && applied_.blows(); ++solves) {
    applied_.take_wind(handed, velocities(u, state));
    set_force();
    solve_.certify(options_.tolerance, handed, report);
    if (report.converged || solves == kMostWind) break;
    applied_.relax_wind();
    set_force();
    handed = solve_.minimise(options_.tolerance, u, report);
  }
  return handed;
}

/// Writes displacements, velocities and accelerations to the state.
/// @param u  the minimum, from which velocities and accelerations follow.
void ImplicitFem::finish(const Array<double>& u, Array<double> handed, FemState& state,
                         FemStepReport& report) {
  const double dt = period_.dt;
  Array<double> v = velocities(u, state), Mv(u.rows(), 3);
  // accelerations of Newmark's scheme, and the energy of gravity
  for (int64_t k = 0; k < u.size(); ++k) {
    if (scene_.scheme == Scheme::kNewmark)
      state.a.data()[k] = 4 / (dt * dt) * (u.data()[k] - predictor_.data()[k]);
    const double x = scene_.mesh.rest.data()[k] + u.data()[k];
    report.energy.gravity -= solve_.weight().data()[k] * x;
  }
  report.damped = dt * terms_.damping_power(handed);
  const Vec3 pull = scene_.scheme == Scheme::kNewmark ? Vec3{} : scene_.gravity;
  potential_.held_gradient(handed.data(), pull, holding_.data());
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
  const int64_t inner = solve_.iterations();
  begin(state);
  FemStepReport report;
  report.step = state.steps + 1;
  report.time = period.end;
  report.scheme = scheme_.scheme;
  report.used = scheme_.scheme == TimeScheme::kBdf2 ? Scheme::kBdf2 : Scheme::kEuler;
  if (scene_.scheme == Scheme::kNewmark) report.used = Scheme::kNewmark;

  // materials without a potential begin with a frozen one
  if (terms_.plastic) terms_.plastic->body().freeze(state.u);
  Array<double> u = solve_.start_value(state.u, {predictor_}, period.end);
  const bool clear = solve_.pass_colliders(u);
  Array<double> handed = minimise(state, u, report);
  report.inner = int(solve_.iterations() - inner);
  if (!clear) report.finite = false, report.refusal = kNoRoom;
  if (report.finite) finish(u, std::move(handed), state, report);
  report.ms = watch.milliseconds();
  return report;
}

}  // namespace elastogen::fem
