// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/static_fem.hpp"

#include "core/error.hpp"
#include "core/reduce.hpp"
#include "mpm_fem/integrators/equilibrium.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {
namespace {

constexpr int kMaxRotations = 30;     // times that rotations are frozen anew
constexpr double kWorstFloor = 1e-4;  // relative residual that may be due to rounding
constexpr int kEasy = 8;              // Newton steps after which the next increment is not larger

class Statics {
 public:
  Statics(const FemScene& scene, const StaticOptions& options)
      : scene_(scene),
        options_(options),
        terms_(scene, options.linear),
        potential_(terms_.potential) {
    ELASTOGEN_CHECK(!terms_.viscous, "statics have no damping");
    if (terms_.plastic) result_.plastic = terms_.plastic->body().rest_history();
    weight_ = Array<double>(scene.mesh.rest.rows(), 3);
    Array<double> gravity(weight_.rows(), 3);
    for (int64_t k = 0; k < gravity.size(); ++k) gravity.data()[k] = scene.gravity[size_t(k % 3)];
    potential_.mass().multiply(gravity.data(), weight_.data());
    result_.u = Array<double>(weight_.rows(), 3);
  }

  StaticResult run();

 private:
  void set_loads(double factor);
  double reference(const Array<double>& u);
  NewtonResult minimise(Array<double>& u);
  NewtonResult settle(Array<double>& u);
  void commit(const Array<double>& u);
  bool advance(double factor);
  void finish();

  const FemScene& scene_;
  const StaticOptions& options_;
  FemPotential terms_;
  Potential& potential_;  // of the terms
  Array<double> weight_, load_;
  StaticResult result_;
  double reference_ = 0;
};

void Statics::set_loads(double factor) {
  terms_.move_dependent(factor);
  load_ = applied_force(scene_, factor, factor);
  for (int64_t k = 0; k < load_.size(); ++k) load_.data()[k] += factor * weight_.data()[k];
  potential_.set_force(load_);
}

/// The larger of the loads on free components and the forces on the others [N].
double Statics::reference(const Array<double>& u) {
  std::vector<double> g(size_t(u.size()));
  potential_.full_gradient(u.data(), g.data());
  double loads = 0, holds = 0;
  for (int64_t k = 0; k < u.size(); ++k) {
    const bool bound = potential_.is_bound(k);
    const double value = bound ? g[size_t(k)] : load_.data()[k];
    (bound ? holds : loads) += value * value;
  }
  return std::sqrt(std::max(loads, holds));
}

/// Newton's method, repeated with the rotations of its result until they fit.
NewtonResult Statics::minimise(Array<double>& u) {
  NewtonResult sum, last;
  for (int k = 0; k < kMaxRotations; ++k) {
    reference_ = reference(u);
    last = potential_.minimise(
        {.tolerance = options_.tolerance * reference_, .max_iterations = options_.max_newton},
        u.data());
    sum.iterations += last.iterations;
    const bool ended = last.stop != NewtonStop::kConverged && last.stop != NewtonStop::kRoundOff;
    if (ended || (k > 0 && last.iterations == 0)) break;
    if (scene_.mesh.element != Element::kVoxel) break;
    terms_.freeze_rotations(u);
  }
  last.iterations = sum.iterations;
  return last;
}

/// The equilibrium where materials yield.
NewtonResult Statics::settle(Array<double>& u) {
  reference_ = reference(u);
  const Equilibrium found = find_equilibrium(
      terms_, {.tolerance = options_.tolerance * reference_, .max_iterations = options_.max_newton},
      u.data());
  std::vector<double> g(size_t(u.size()));
  potential_.free_gradient(u.data(), g.data());
  NewtonResult result;
  result.stop = found.stop;
  result.iterations = found.iterations;
  result.noise = found.noise;
  result.residual = norm(g.data(), u.size());
  return result;
}

/// Keeps the flow of an increment that ends at u.
void Statics::commit(const Array<double>& u) {
  PlasticBody& body = terms_.plastic->body();
  result_.energy.plastic += body.work(u).plastic;
  result_.plastic = body.history_after(u);
  body.set_history(result_.plastic);
}

/// One increment up to a load factor. False: it failed, and u is as it was.
bool Statics::advance(double factor) {
  set_loads(factor);
  Array<double> u = result_.u;
  terms_.freeze_rotations(u);
  potential_.move_fixed(with_motion(scene_, factor, u), u.data());
  const NewtonResult newton = terms_.plastic ? settle(u) : minimise(u);
  result_.newton_steps += newton.iterations;
  result_.stop = newton.stop;
  const double force = reference_ > 0 ? reference_ : 1;
  result_.residual = newton.residual / force;
  result_.floor = newton.noise / force;
  const bool rounded = newton.stop == NewtonStop::kRoundOff && result_.residual <= kWorstFloor;
  if (newton.stop != NewtonStop::kConverged && !rounded) return false;
  ++result_.increments;
  result_.load_factor = factor;
  if (terms_.plastic) commit(u);
  result_.u = std::move(u);
  return true;
}

/// Reactions and energies at the last equilibrium.
void Statics::finish() {
  const Array<double>& u = result_.u;
  set_loads(result_.load_factor);
  terms_.freeze_rotations(u);
  result_.reaction = Array<double>(u.rows(), 3);
  potential_.full_gradient(u.data(), result_.reaction.data());
  const double plastic = result_.energy.plastic;
  result_.energy = terms_.energy(u);
  result_.energy.plastic += plastic;
  result_.gradient = result_.reaction;
  potential_.restrict(result_.gradient.data());
  for (int64_t k = 0; k < u.size(); ++k) {
    result_.reaction.data()[k] -= result_.gradient.data()[k];
    result_.energy.gravity -= result_.load_factor * weight_.data()[k] * u.data()[k];
  }
  result_.min_j = terms_.min_j(u);
}

StaticResult Statics::run() {
  const double largest = terms_.plastic ? std::min(1.0, options_.largest_flow) : 1;
  double increment = std::min(largest, options_.first_increment);
  while (result_.load_factor < 1 && increment >= options_.smallest_increment) {
    const int before = result_.newton_steps;
    if (!advance(std::min(1.0, result_.load_factor + increment)))
      increment /= 2;
    else if (result_.newton_steps - before <= kEasy)
      increment = terms_.plastic ? std::min(largest, 2 * increment) : 2 * increment;
  }
  result_.converged = result_.load_factor == 1;
  finish();
  return std::move(result_);
}

}  // namespace

StaticResult solve_static(const FemScene& scene, const StaticOptions& options) {
  ELASTOGEN_CHECK(options.tolerance > 0 && options.first_increment > 0 &&
                      options.smallest_increment > 0 && options.largest_flow > 0,
                  "tolerance and increments must be positive, got ", options.tolerance, ", ",
                  options.first_increment, ", ", options.smallest_increment, ", ",
                  options.largest_flow);
  return Statics(scene, options).run();
}

}  // namespace elastogen::fem
