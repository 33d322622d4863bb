// SPDX-License-Identifier: Apache-2.0
// A step: where it starts, how it ends, and what it makes of the state.
#include "core/error.hpp"
#include "core/stopwatch.hpp"
#include "network/solver_impl.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

/// Phi in float64.
double Solver::Impl::phi(const Zeroed<double>& at) {
  return potential->evaluate<double>(at.data(), gradient.data()).total();
}

/// Phi in float where that has the digits, to find where iterations begin.
double Solver::Impl::rough_phi(const Zeroed<double>& at) {
  if (precise) return phi(at);
  return potential->evaluate(at.data(), static_cast<float*>(nullptr)).total();
}

/// Extrapolations save iterations where forces go on as they were; where waves run through a body
/// the predictor, far away as it is, can do with fewer: it leaves errors that iterations find soon.
bool Solver::Impl::begins_by_extrapolation(int64_t step) {
  if (!extrapolates) return false;
  way = starts[int(mode)].choose(step);
  return way == 0;
}

/// The start of the predictor, or where Phi is lower an extrapolation.
void Solver::Impl::choose_start(const State& state) {
  predictor.start(state, potential->predictor(), u.data());
  if (!begins_by_extrapolation(state.steps + 1)) return;
  Zeroed<double> other = u;
  double lowest = rough_phi(u);
  for (int order = 1; order <= Predictor::orders(!state.x_before.empty()); ++order) {
    predictor.extrapolate(state, scheme, order, other.data());
    const double phi = rough_phi(other);
    if (!(phi < lowest || std::isnan(lowest))) continue;
    lowest = phi;
    u.swap(other);
  }
}

/// Predictor, inertia and rotations of the step, and u where it starts; gives the collider that
/// rules it out, else null.
const Collider* Solver::Impl::begin_step(const State& state) {
  if (on_device) {
    on_device->begin_step(scheme, state.time);
    if (mode == SolverMode::kPaper) return nullptr;
    const Collider* inside = start_on_device(state.steps + 1);
    if (!inside) on_device->set_nodal_rotations();
    return inside;
  }
  potential->begin_step(state, scheme);
  if (paper) return nullptr;
  const Collider* inside = start(state);
  if (!inside) potential->set_nodal_rotations(u.data());
  return inside;
}

/// The chosen start, cut where it would carry a surface point through the floor, or the state
/// before where a start that leaves it by more than a voxel has the higher potential (a small
/// pinned body falls many times its size in a step). What a collider would run over moves along
/// with it; gives the collider that a point lies in all the same, else null.
const Collider* Solver::Impl::start(const State& state) {
  choose_start(state);
  Zeroed<double> now = potential->now();
  double farthest = 0;
  for (size_t k = 0; k < u.size(); ++k) farthest = std::max(farthest, std::abs(u[k] - now[k]));
  if (potential->contact().exists()) {
    potential->contact().carry(now.data());
    if (const Collider* inside = potential->contact().obstacle(now.data())) return inside;
    const double share = potential->contact().longest_step(now.data(), u.data());
    if (share < 1)
      for (size_t k = 0; k < u.size(); ++k) u[k] = now[k] + share * (u[k] - now[k]);
  }
  if (!pinned || farthest < scene.grid.h) return nullptr;
  if (!(rough_phi(u) < rough_phi(now))) u = now;
  return nullptr;
}

/// The same on the device.
const Collider* Solver::Impl::start_on_device(int64_t step) {
  if (begins_by_extrapolation(step)) on_device->choose_start();
  const bool far = pinned && on_device->farthest() >= scene.grid.h;
  if (const Collider* inside = on_device->clear_start()) return inside;
  if (far && !on_device->is_below_clear_start()) on_device->return_to_clear_start();
  return nullptr;
}

/// Where the iterations ended above the potential of the state before, they begin there once more:
/// a step that ends at or below it, converged or not, brings no energy (Phi there is the energy at
/// the start of the step, and no less than that at its end).
IterationResult Solver::Impl::retreat(double target) {
  if (on_device) {
    if (!(on_device->phi_now() < on_device->phi())) return {};
    on_device->return_to_now();
  } else {
    if (!(phi(potential->now()) < phi(u))) return {};
    u = potential->now();
  }
  return newton(target);
}

/// Gives pieces in free flight the mean motion of their predictor, which the iterations know to the
/// tolerance only, as long as they do not touch anything there.
void Solver::Impl::balance() {
  const auto touches = [&] {
    return potential->contact().evaluate(u.data(), static_cast<double*>(nullptr)) != 0;
  };
  in_flight = flight.exists() && !paper && !touches();
  if (!in_flight) return;
  u_before_shift = u;
  const Zeroed<double>& aim = potential->predictor();
  flight.match_means(u.data(), [&](size_t n, size_t d) { return aim[3 * n + d]; });
  if (!touches()) return;
  u.swap(u_before_shift);
  in_flight = false;
}

/// x from u, and the residual of the true equations in float64 on that x.
Certificate Solver::Impl::measure(const State& state) {
  gradient_on_device = on_device != nullptr;
  if (on_device) {
    const Certificate result = on_device->certify(flight.exists() && mode != SolverMode::kPaper);
    in_flight = result.in_flight;
    return result;
  }
  balance();
  const Array<double>& X = scene.grid.rest;
  x = state.x;
  for_each(X.rows(), [&](int64_t n) {
    for (int d = 0; d < 3; ++d) {
      if (!scene.pinned(n)) x(n, d) = X(n, d) + u[size_t(3 * n + d)];
      u[size_t(3 * n + d)] = x(n, d) - X(n, d);
    }
  });
  Certificate result{potential->residual(u.data(), gradient.data()), 0, false};
  result.size = norm(gradient.data(), int64_t(gradient.size()));
  result.finite = std::isfinite(result.value.total()) && std::isfinite(result.size) &&
                  all_finite(u.data(), int64_t(u.size()));
  return result;
}

void Solver::Impl::certify(const State& state, StepReport& report) {
  const Certificate certificate = measure(state);
  const PotentialValue& value = certificate.value;
  report.residual = force > 0 ? certificate.size / force : 0;
  report.converged = report.residual <= options.tolerance;
  report.finite = certificate.finite;
  report.min_j = value.min_j;
  report.min_corner_j = value.min_corner_j;
  report.deepest_overlap = value.deepest_overlap / scene.grid.h;
  report.energy.elastic = value.elastic;
  report.energy.hourglass = value.hourglass;
  report.energy.contact = value.contact;
  report.outside_fit = value.outside;
}

/// Takes from v what the rounding of positions brings into its mean.
void Solver::Impl::conserve_momentum(const State& state, Array<double>& v) {
  const Array<double>& before = state.v_before.empty() ? state.v : state.v_before;
  flight.match_means(v.data(), [&](size_t n, size_t d) {
    const auto node = int64_t(n);
    return free_velocity(scheme, state.v(node, int64_t(d)), before(node, int64_t(d)),
                         scene.gravity[d]);
  });
}

/// Hands the new positions and velocities to the state.
MotionEnergy Solver::Impl::take_positions(State& state) {
  Array<double> v(x.rows(), 3);
  for_each(x.rows(), [&](int64_t n) {
    for (int d = 0; d < 3; ++d) {
      const double before = state.x_before.empty() ? state.x(n, d) : state.x_before(n, d);
      if (!scene.pinned(n)) v(n, d) = velocity_after(scheme, x(n, d), state.x(n, d), before);
    }
  });
  if (in_flight) conserve_momentum(state, v);
  MotionEnergy energy;
  for (int64_t n = 0; n < x.rows(); ++n)
    for (int d = 0; d < 3; ++d) {
      energy.kinetic += scene.mass(n) / 2 * v(n, d) * v(n, d);
      energy.gravity -= scene.mass(n) * scene.gravity[size_t(d)] * x(n, d);
    }
  state.x_before = std::move(state.x);
  state.v_before = std::move(state.v);
  state.x = std::move(x);
  state.v = std::move(v);
  return energy;
}

void Solver::Impl::finish(State& state, StepReport& report) {
  const MotionEnergy energy = on_device ? on_device->finish() : take_positions(state);
  report.energy.kinetic = energy.kinetic;
  report.energy.gravity = energy.gravity;
  ++state.steps;
  state.time = double(state.steps) * scene.dt;
}

/// Iterates and certifies; false where the step was given up on request.
bool Solver::Impl::solve(const State& state, StepReport& report) {
  // a margin, because the state that is written is rounded once more
  const double target = 0.95 * options.tolerance * force;
  IterationResult result = choose(target, report);
  const bool paper_mode = mode == SolverMode::kPaper;
  if (!result.converged && !paper_mode && !options.interrupted())
    result = sum(result, retreat(target));
  report.interrupted = options.interrupted();
  if (report.interrupted) return false;
  certify(state, report);
  if (!report.converged && !report.float64 && report.finite && !paper_mode) {
    report.float64 = true;
    result = sum(result, quasi(quasi_double, target, single));
    certify(state, report);
  }
  report.outer = result.outer;
  report.inner = result.inner;
  return true;
}

StepReport Solver::Impl::advance(State& state) {
  const Stopwatch watch;
  StepReport report;
  scheme = step_scheme(scene, on_device ? on_device->has_before() : !state.x_before.empty());
  report.scheme = scheme.scheme;
  report.step = state.steps + 1;
  report.time = double(report.step) * scene.dt;
  if (const Collider* inside = begin_step(state)) {
    report.finite = false;
    report.refusal = concat("collider '", inside->name, "' runs into a part that cannot give way (",
                            "pinned, or held by another collider)");
    return report;
  }
  if (!solve(state, report)) return report;
  if (report.finite) finish(state, report);
  report.ms = watch.milliseconds();
  return report;
}

Span<const double> Solver::residual() const {
  if (impl_->gradient_on_device) impl_->on_device->download_gradient(impl_->gradient.data());
  impl_->gradient_on_device = false;
  return {impl_->gradient.data(), int64_t(impl_->gradient.size() / 3), 3};
}

void Solver::begin(const State& state) {
  Impl& s = *impl_;
  check_state(state, s.scene.grid.node_count());
  s.in_clip = true;
  if (!s.on_device) {
    s.clip = state;
    return;
  }
  s.on_device->upload(state);
  s.clip.time = state.time;
  s.clip.steps = state.steps;
}

StepReport Solver::advance() {
  ELASTOGEN_CHECK(impl_->in_clip, "advance() comes after begin()");
  return impl_->advance(impl_->clip);
}

void Solver::read(State& state, StateParts parts) const {
  const Impl& s = *impl_;
  ELASTOGEN_CHECK(s.in_clip, "read() comes after begin()");
  if (s.on_device)
    s.on_device->download(state, parts);
  else if (parts == StateParts::kAll)
    state = s.clip;
  else
    state.x = s.clip.x;
  state.time = s.clip.time;
  state.steps = s.clip.steps;
}

StepReport Solver::step(State& state) {
  Impl& s = *impl_;
  if (!s.on_device) {
    check_state(state, s.scene.grid.node_count());
    s.in_clip = false;
    return s.advance(state);
  }
  const Stopwatch watch;
  begin(state);
  StepReport report = advance();
  if (report.finite && !report.interrupted) read(state, StateParts::kAll);
  s.in_clip = false;
  report.ms = watch.milliseconds();
  return report;
}

}  // namespace elastogen
