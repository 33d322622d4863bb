// SPDX-License-Identifier: Apache-2.0
#include "network/solver.hpp"

#include "core/error.hpp"
#include "network/device.hpp"
#include "network/free_flight.hpp"
#include "network/newton_solver.hpp"
#include "network/paper_solver.hpp"
#include "network/predictor.hpp"
#include "network/quasi_solver.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kNewtonCourant = 100;   // auto: newton from here on,
constexpr double kNewtonPoisson = 0.47;  // or here,
constexpr double kCheap = 80;            // cost of a step that auto does not try to better
constexpr int kRetry = 10;               // steps after which auto tries the other mode again
constexpr double kDoubleCourant = 1000;  // everything in float64
constexpr double kEncoderCourant = 2;    // below it multigrid alone does as well

}  // namespace

struct Solver::Impl {
  Impl(const Scene& s, const SolverOptions& o)
      : scene(s),
        options(o),
        potential(s, o.learned),
        predictor(s),
        flight(s),
        force(reference_force(s)),
        courant(courant_number(s)),
        u(3 * size_t(s.grid.node_count())),
        gradient(u.size()) {
    ELASTOGEN_CHECK(o.tolerance > 0 && std::isfinite(o.tolerance),
                    "the tolerance must be positive, got ", o.tolerance);
    ELASTOGEN_CHECK(o.max_outer >= 0 && o.max_inner >= 0, "iteration limits must not be negative, ",
                    "got ", o.max_outer, " and ", o.max_inner);
    pinned = std::any_of(s.pinned.data(), s.pinned.data() + s.pinned.rows(),
                         [](uint8_t p) { return p != 0; });
    mode = o.mode;
    if (mode == SolverMode::kAuto) mode = stiff() ? SolverMode::kNewton : SolverMode::kQuasi;
    if (mode == SolverMode::kPaper) {
      ELASTOGEN_CHECK(o.device != Device::kCuda, "the paper mode runs on the CPU");
      paper.emplace(potential, o.paper);
      return;
    }
    // the preconditioner is built for the scheme of the run, at rest
    State rest = initial_state(scene);
    StepScheme scheme{scene.scheme, scene.dt, scene.scheme == TimeScheme::kBdf2 ? 2.25 : 1};
    rest.x_before = rest.x;
    rest.v_before = rest.v;
    potential.begin_step(rest, scheme);
    const bool encoder = !o.skip || courant > kEncoderCourant;
    // forces beyond the range of float, or conditions beyond its digits
    const bool in_range = force < 1e25 && force > 1e-25;
    if (courant > kDoubleCourant || !in_range)
      precise.emplace(potential, encoder);
    else
      single.emplace(potential, encoder);
    take_device();
  }

  bool stiff() const {
    double poisson = 0;
    for (const Material& m : scene.materials) poisson = std::max(poisson, m.poisson);
    return courant > kNewtonCourant || poisson > kNewtonPoisson;
  }
  const char* unfit_for_device() const;
  void take_device();
  IterationResult iterate(double target, StepReport& report);
  IterationResult choose(double target, StepReport& report);
  double cost(const IterationResult& r) const;
  template <class T, class P>
  IterationResult quasi(std::unique_ptr<QuasiSolver<T>>& solver, double target,
                        Preconditioner<P>& first) {
    if (on_device)
      return on_device->solve(u.data(), target, options.max_outer, sizeof(T) == 8,
                              options.interrupted);
    if (!solver) solver = std::make_unique<QuasiSolver<T>>(potential);
    return solver->solve(u.data(), target, options.max_outer, first, options.interrupted);
  }
  double phi(const std::vector<double>& at);
  IterationResult newton(double target);
  IterationResult retreat(const State& state, double target);
  std::vector<double> displacement(const State& state) const;
  const Collider* start(const State& state);
  void balance();
  void certify(const State& state, StepReport& report);
  void conserve_momentum(const State& state, Array<double>& v);
  void finish(State& state, StepReport& report);

  const Scene& scene;
  SolverOptions options;
  IncrementalPotential potential;
  Predictor predictor;
  FreeFlight flight;
  bool in_flight = false;  // free pieces are there, and nothing touches
  double force, courant;
  bool pinned = false;
  SolverMode mode;
  double last_cost[4] = {};  // of each mode
  int64_t last_step[4] = {-kRetry, -kRetry, -kRetry, -kRetry};
  std::optional<Preconditioner<float>> single;
  std::optional<Preconditioner<double>> precise;
  std::unique_ptr<cuda::DeviceIterations> on_device;
  bool gradient_on_device = false;  // that of the certificate
  std::unique_ptr<QuasiSolver<float>> quasi_float;
  std::unique_ptr<QuasiSolver<double>> quasi_double;
  std::unique_ptr<NewtonSolver> newton_solver;
  std::optional<PaperSolver> paper;
  std::vector<double> u, gradient, u_before_shift;
  Array<double> x;  // of the new state
};

/// Why the device cannot take this scene, null if it can.
const char* Solver::Impl::unfit_for_device() const {
  if (!single) return "float has too few digits for it";
  if (mode != SolverMode::kQuasi) return "it is one for newton, which runs on the CPU";
  if (potential.contact().exists()) return "colliders are left to the CPU";
  for (size_t m = 0; m < scene.materials.size(); ++m) {
    const LearnedLaw* net = potential.learned(m);
    if (net && net->evaluation() == Evaluation::kNet)
      return "nets without a table are left to the CPU";
  }
  return nullptr;
}

void Solver::Impl::take_device() {
  const bool asked = options.device == Device::kCuda;
  if (options.device == Device::kCpu || (!asked && (unfit_for_device() || !cuda::has_device())))
    return;
  if (!cuda::has_device())
    throw Error("there is no CUDA device, or none that this build can use: leave out --device cuda",
                ErrorKind::kDevice);
  ELASTOGEN_CHECK(!unfit_for_device(), "the device cannot take the scene: ", unfit_for_device());
  try {
    on_device = cuda::make_device_iterations(potential, *single);
  } catch (const Error& error) {  // no room there: auto goes on here
    if (asked || error.kind() != ErrorKind::kResources) throw;
  }
}

std::vector<double> Solver::Impl::displacement(const State& state) const {
  std::vector<double> now(u.size());
  for_each(int64_t(u.size()),
           [&](int64_t k) { now[size_t(k)] = state.x.data()[k] - scene.grid.rest.data()[k]; });
  return now;
}

/// Phi in float64.
double Solver::Impl::phi(const std::vector<double>& at) {
  if (on_device) return on_device->value(at.data()).total();
  return potential.evaluate<double>(at.data(), gradient.data()).total();
}

/// The predictor, cut where it would carry a surface point through the floor, or the state before
/// where a predictor that leaves it by more than a voxel has the higher potential (a small pinned
/// body falls many times its size in a step). What a collider would run over moves along with it;
/// gives the collider that a point lies in all the same, else null.
const Collider* Solver::Impl::start(const State& state) {
  predictor.start(state, potential.predictor(), u.data());
  std::vector<double> now = displacement(state);
  double farthest = 0;
  for (size_t k = 0; k < u.size(); ++k) farthest = std::max(farthest, std::abs(u[k] - now[k]));
  if (potential.contact().exists()) {
    potential.contact().carry(now.data());
    if (const Collider* inside = potential.contact().obstacle(now.data())) return inside;
    const double share = potential.contact().longest_step(now.data(), u.data());
    if (share < 1)
      for (size_t k = 0; k < u.size(); ++k) u[k] = now[k] + share * (u[k] - now[k]);
  }
  if (!pinned || farthest < scene.grid.h) return nullptr;
  const double ahead = phi(u), here = phi(now);
  if (!(ahead < here)) u = now;
  return nullptr;
}

IterationResult Solver::Impl::newton(double target) {
  if (!newton_solver) newton_solver = std::make_unique<NewtonSolver>(potential);
  if (on_device) {  // which has left this to us
    potential.freeze_rotations();
    potential.set_nodal_rotations(u.data());
  }
  const int outer = std::max(1, options.max_outer / 4);
  if (precise)
    return newton_solver->solve(u.data(), target, outer, options.max_inner, *precise,
                                options.interrupted);
  return newton_solver->solve(u.data(), target, outer, options.max_inner, *single,
                              options.interrupted);
}

/// The mode that was asked for.
IterationResult Solver::Impl::iterate(double target, StepReport& report) {
  report.float64 = true;
  if (paper) return paper->solve(u.data(), options.interrupted);
  if (mode == SolverMode::kNewton) return newton(target);
  if (precise) return quasi(quasi_double, target, *precise);
  IterationResult result;
  if (options.skip && float_floor(scene) < options.tolerance / 3) {
    report.float64 = false;
    result = quasi(quasi_float, target, *single);
    if (result.converged) return result;
    report.float64 = true;
  }
  return sum(result, quasi(quasi_double, target, *single));
}

/// What a step cost, in passes of the preconditioner: one of quasi comes with an evaluation, one of
/// newton with a product, and a Newton step with Hessian and evaluation.
double Solver::Impl::cost(const IterationResult& r) const {
  return mode == SolverMode::kNewton ? 1.3 * r.inner + 3 * r.outer : 2 * r.inner;
}

/// auto: quasi while that is cheap, else the cheaper of both; what one cannot do the other tries.
/// The device stays with quasi.
IterationResult Solver::Impl::choose(double target, StepReport& report) {
  if (options.mode != SolverMode::kAuto || stiff()) return iterate(target, report);
  IterationResult result = iterate(target, report);
  const SolverMode other = mode == SolverMode::kNewton ? SolverMode::kQuasi : SolverMode::kNewton;
  last_cost[int(mode)] = cost(result);
  last_step[int(mode)] = report.step;
  const bool stale = report.step - last_step[int(other)] >= kRetry;
  const bool dear = !on_device && (last_cost[int(mode)] > kCheap || mode == SolverMode::kNewton);
  const bool better = last_cost[int(other)] < last_cost[int(mode)];
  if (!result.converged && !options.interrupted()) {
    mode = other;
    result = sum(result, iterate(target, report));
    if (on_device) mode = SolverMode::kQuasi;
  } else if (dear && (stale || better)) {
    mode = other;
  }
  return result;
}

/// Gives pieces in free flight the mean motion of their predictor, which the iterations know to the
/// tolerance only, as long as they do not touch anything there.
void Solver::Impl::balance() {
  const auto touches = [&] {
    return potential.contact().evaluate(u.data(), static_cast<double*>(nullptr)) != 0;
  };
  in_flight = flight.exists() && !paper && !touches();
  if (!in_flight) return;
  u_before_shift = u;
  const std::vector<double>& aim = potential.predictor();
  flight.match_means(u.data(), [&](size_t n, size_t d) { return aim[3 * n + d]; });
  if (!touches()) return;
  u.swap(u_before_shift);
  in_flight = false;
}

/// Where the iterations ended above the potential of the state before, they begin there once more:
/// a step that ends at or below it, converged or not, brings no energy (Phi there is the energy at
/// the start of the step, and no less than that at its end).
IterationResult Solver::Impl::retreat(const State& state, double target) {
  const std::vector<double> now = displacement(state);
  if (!(phi(now) < phi(u))) return {};
  u = now;
  return newton(target);
}

/// x from u, and the residual of the true equations in float64 on that x.
void Solver::Impl::certify(const State& state, StepReport& report) {
  const Array<double>& X = scene.grid.rest;
  balance();
  x = state.x;
  for_each(X.rows(), [&](int64_t n) {
    for (int d = 0; d < 3; ++d) {
      if (!scene.pinned(n)) x(n, d) = X(n, d) + u[size_t(3 * n + d)];
      u[size_t(3 * n + d)] = x(n, d) - X(n, d);
    }
  });
  PotentialValue value;
  double size = 0;
  gradient_on_device = on_device != nullptr;
  if (on_device) {
    value = on_device->residual(u.data(), size);
  } else {
    value = potential.residual(u.data(), gradient.data());
    size = norm(gradient.data(), int64_t(gradient.size()));
  }
  report.residual = force > 0 ? size / force : 0;
  report.converged = report.residual <= options.tolerance;
  report.finite = std::isfinite(value.total()) && std::isfinite(size) &&
                  all_finite(u.data(), int64_t(u.size()));
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
  const StepScheme& scheme = potential.scheme();
  const Array<double>& before = state.v_before.empty() ? state.v : state.v_before;
  flight.match_means(v.data(), [&](size_t n, size_t d) {
    const auto node = int64_t(n);
    return free_velocity(scheme, state.v(node, int64_t(d)), before(node, int64_t(d)),
                         scene.gravity[d]);
  });
}

/// Hands the new positions and velocities to the state.
void Solver::Impl::finish(State& state, StepReport& report) {
  const StepScheme& scheme = potential.scheme();
  Array<double> v(x.rows(), 3);
  for_each(x.rows(), [&](int64_t n) {
    for (int d = 0; d < 3; ++d) {
      const double before = state.x_before.empty() ? state.x(n, d) : state.x_before(n, d);
      if (!scene.pinned(n)) v(n, d) = velocity_after(scheme, x(n, d), state.x(n, d), before);
    }
  });
  if (in_flight) conserve_momentum(state, v);
  for (int64_t n = 0; n < x.rows(); ++n)
    for (int d = 0; d < 3; ++d) {
      report.energy.kinetic += scene.mass(n) / 2 * v(n, d) * v(n, d);
      report.energy.gravity -= scene.mass(n) * scene.gravity[size_t(d)] * x(n, d);
    }
  state.x_before = std::move(state.x);
  state.v_before = std::move(state.v);
  state.x = std::move(x);
  state.v = std::move(v);
  ++state.steps;
  state.time = double(state.steps) * scene.dt;
}

Solver::Solver(const Scene& scene, const SolverOptions& options)
    : impl_(std::make_unique<Impl>(scene, options)) {}

Solver::~Solver() = default;

Span<const double> Solver::residual() const {
  if (impl_->gradient_on_device) impl_->on_device->download_gradient(impl_->gradient.data());
  impl_->gradient_on_device = false;
  return {impl_->gradient.data(), int64_t(impl_->gradient.size() / 3), 3};
}

SolverMode Solver::mode() const {
  return impl_->mode;
}

std::string Solver::device() const {
  return impl_->on_device ? cuda::device_name() : "cpu";
}

StepReport Solver::step(State& state) {
  const auto begin = std::chrono::steady_clock::now();
  Impl& s = *impl_;
  check_state(state, s.scene.grid.node_count());
  StepReport report;
  const StepScheme scheme = step_scheme(s.scene, state);
  report.scheme = scheme.scheme;
  report.step = state.steps + 1;
  report.time = double(report.step) * s.scene.dt;
  s.potential.begin_step(state, scheme, !s.on_device);
  if (s.on_device) s.on_device->begin_step();
  if (!s.paper) {
    if (const Collider* inside = s.start(state)) {
      report.finite = false;
      report.refusal =
          concat("collider '", inside->name, "' runs into a part that cannot give way (",
                 "pinned, or held by another collider)");
      return report;
    }
    if (s.on_device)
      s.on_device->set_nodal_rotations(s.u.data());
    else
      s.potential.set_nodal_rotations(s.u.data());
  }

  // a margin, because the state that is written is rounded once more
  const double target = 0.95 * s.options.tolerance * s.force;
  IterationResult result = s.choose(target, report);
  if (!result.converged && !s.paper && !s.options.interrupted())
    result = sum(result, s.retreat(state, target));
  report.interrupted = s.options.interrupted();
  if (report.interrupted) return report;
  s.certify(state, report);
  if (!report.converged && !report.float64 && report.finite) {
    report.float64 = true;
    result = sum(result, s.quasi(s.quasi_double, target, *s.single));
    s.certify(state, report);
  }
  report.outer = result.outer;
  report.inner = result.inner;
  if (report.finite) s.finish(state, report);
  const auto end = std::chrono::steady_clock::now();
  report.ms = std::chrono::duration<double, std::milli>(end - begin).count();
  return report;
}

}  // namespace elastogen
