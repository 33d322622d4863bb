// SPDX-License-Identifier: Apache-2.0
// What a solver is built of, and the modes.
#include "network/solver.hpp"

#include "core/error.hpp"
#include "network/solver_impl.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kNewtonCourant = 100;   // auto: newton from here on,
constexpr double kNewtonPoisson = 0.47;  // or here,
constexpr double kCheap = 40;            // cost of a step that auto does not try to better
constexpr double kDoubleCourant = 1000;  // everything in float64
constexpr double kEncoderCourant = 2;    // below it multigrid alone does as well,
constexpr double kEncoderSoftness = 5;  // and below it too: beams and balls take as many iterations

}  // namespace

Solver::Impl::Impl(const Scene& s, const SolverOptions& o)
    : scene(s),
      options(o),
      // tables are built for the scheme of the run
      terms(std::in_place, s, o.learned,
            StepScheme{s.scheme, s.dt, s.scheme == TimeScheme::kBdf2 ? 2.25 : 1}),
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
  extrapolates = pinned || !s.colliders.empty();
  std::fill(std::begin(last_step), std::end(last_step), -kRetry);
  mode = o.mode;
  if (mode == SolverMode::kAuto) mode = stiff() ? SolverMode::kNewton : SolverMode::kQuasi;
  if (mode == SolverMode::kPaper) {
    check_paper_scene(*terms, o.paper);
    take_device({}, true);
    if (on_device) return;
    paper.emplace(take_potential(), o.paper);
    return;
  }
  // contact may ask for what rest does not
  const EncoderChoice encoder{!o.skip || courant > kEncoderCourant,
                              o.skip && scene.colliders.empty() ? kEncoderSoftness : 0};
  // forces beyond the range of float, or conditions beyond its digits
  const bool in_float = courant <= kDoubleCourant && force < 1e25 && force > 1e-25;
  take_device(encoder, in_float);
  if (on_device) return;  // which has its own
  if (in_float)
    single.emplace(take_potential(), encoder);
  else
    precise.emplace(take_potential(), encoder);
}

/// That of the host, from the terms.
IncrementalPotential& Solver::Impl::take_potential() {
  potential.emplace(std::move(*terms));
  terms.reset();
  return *potential;
}

bool Solver::Impl::stiff() const {
  double poisson = 0;
  for (const Material& m : scene.materials) poisson = std::max(poisson, m.poisson);
  return courant > kNewtonCourant || poisson > kNewtonPoisson;
}

/// @param in_float  whether float has the digits for the scene.
void Solver::Impl::take_device(const EncoderChoice& encoder, bool in_float) {
  const bool asked = options.device == Device::kCuda;
  if (options.device == Device::kCpu || (!asked && (!in_float || !cuda::has_device()))) return;
  if (!cuda::has_device())
    throw Error("there is no CUDA device, or none that this build can use: leave out --device cuda",
                ErrorKind::kDevice);
  ELASTOGEN_CHECK(in_float, "the device cannot take the scene: float has too few digits for it");
  try {
    on_device = mode == SolverMode::kPaper ? cuda::make_device_step(*terms, options.paper)
                                           : cuda::make_device_step(*terms, encoder);
  } catch (const Error& error) {  // no room there: auto goes on here
    if (asked || error.kind() != ErrorKind::kResources) throw;
  }
}

IterationResult Solver::Impl::newton(double target) {
  const int outer = std::max(1, options.max_outer / 4);
  if (on_device) return on_device->newton(target, outer, options.max_inner, options.interrupted);
  if (!newton_solver) newton_solver = std::make_unique<NewtonSolver>(*potential);
  const auto solve = [&](auto& first) {
    return newton_solver->solve(u.data(), target, outer, options.max_inner, first,
                                options.interrupted);
  };
  return precise ? solve(*precise) : solve(*single);
}

/// The mode that was asked for.
IterationResult Solver::Impl::iterate(double target, StepReport& report) {
  report.float64 = true;
  if (mode == SolverMode::kPaper) {
    report.float64 = !on_device;
    return on_device ? on_device->paper(options.interrupted)
                     : paper->solve(u.data(), options.interrupted);
  }
  if (mode == SolverMode::kNewton) return newton(target);
  if (precise) return quasi(quasi_double, target, precise);
  IterationResult result;
  const double float_serves = options.skip ? 3 * float_floor(scene) : kAlways;
  if (float_serves < options.tolerance) {
    report.float64 = false;
    result = quasi(quasi_float, target, single);
    if (result.converged) return result;
    report.float64 = true;
  } else if (on_device) {
    return on_device->solve(target, options.max_outer, float_serves * force, options.interrupted);
  }
  return sum(result, quasi(quasi_double, target, single));
}

/// What a step cost, in passes of the preconditioner: one of quasi comes with an evaluation, one of
/// newton with a product, and a Newton step with Hessian and evaluation.
double Solver::Impl::cost(const IterationResult& r) const {
  if (!r.converged) return kFailed;
  return mode == SolverMode::kNewton ? 1.3 * r.inner + 3 * r.outer : 2 * r.inner;
}

/// What the start of a step cost is set beside what the other one does.
IterationResult Solver::Impl::iterate_and_learn(double target, StepReport& report) {
  const IterationResult result = iterate(target, report);
  if (extrapolates && (result.converged || !options.interrupted()))
    starts[int(mode)].take(way, report.step, cost(result));
  return result;
}

/// auto: quasi while that is cheap, else the cheaper of both; what one cannot do the other tries.
/// Where Phi is not convex quasi gets nowhere, and newton is not left to see whether it does.
IterationResult Solver::Impl::choose(double target, StepReport& report) {
  const bool tried = extrapolates && way != starts[int(mode)].better();
  IterationResult result = iterate_and_learn(target, report);
  if (options.mode != SolverMode::kAuto || stiff() || (tried && result.converged)) return result;
  const SolverMode other = mode == SolverMode::kNewton ? SolverMode::kQuasi : SolverMode::kNewton;
  last_cost[int(mode)] = cost(result);
  last_step[int(mode)] = report.step;
  const bool lost = last_cost[int(other)] > kMuchDearer * last_cost[int(mode)];
  const bool stale = report.step - last_step[int(other)] >= (lost ? kLateRetry : kRetry);
  const bool dear = last_cost[int(mode)] > kCheap || mode == SolverMode::kNewton;
  const bool better = last_cost[int(other)] < last_cost[int(mode)];
  if (!result.converged && !options.interrupted()) {
    mode = other;
    result = sum(result, iterate(target, report));
  } else if (dear && !result.bounded && (stale || better)) {
    mode = other;
  }
  return result;
}

Solver::Solver(const Scene& scene, const SolverOptions& options)
    : impl_(std::make_unique<Impl>(scene, options)) {}

Solver::~Solver() = default;

SolverMode Solver::mode() const {
  return impl_->mode;
}

std::string Solver::device() const {
  return impl_->on_device ? cuda::device_name() : "cpu";
}

}  // namespace elastogen
