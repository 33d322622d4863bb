// SPDX-License-Identifier: Apache-2.0
#include "cli/static_stepper.hpp"

#include "cli/fem_stepper.hpp"
#include "core/stopwatch.hpp"
#include "mpm_fem/integrators/static_fem.hpp"

#include <fmt/format.h>

namespace elastogen {
namespace {

class StaticStepper : public Stepper {
 public:
  StaticStepper(const Setup& setup, const AnimateOptions& options)
      : setup_(setup),
        options_(options),
        scene_(fem_scene(setup, options)),
        residual_(scene_.mesh.rest.rows(), 3) {}

  State start(const StartMotion&) const override {
    State state;
    state.x = scene_.mesh.rest;
    state.v = Array<double>(state.x.rows(), 3);
    return state;
  }
  StepReport step(State& state) override;
  Span<const double> residual() const override { return residual_; }
  void describe(StateHeader& header) const override {
    describe_fem(setup_, options_, scene_, header);
    header.scheme = "static";
  }

 private:
  const Setup& setup_;
  const AnimateOptions& options_;
  fem::FemScene scene_;
  Array<double> residual_;  // of the last step [N], (nodes, 3)
};

StepReport StaticStepper::step(State& state) {
  const Stopwatch watch;
  fem::StaticResult result =
      fem::solve_static(scene_, {.tolerance = fem_tolerance(setup_, options_)});
  for (int64_t k = 0; k < state.x.size(); ++k)
    state.x.data()[k] = scene_.mesh.rest.data()[k] + result.u.data()[k];
  state.time = result.load_factor;
  ++state.steps;
  residual_ = std::move(result.gradient);
  StepReport report;
  report.step = state.steps;
  report.time = state.time;
  report.converged = result.converged;
  report.residual = result.residual;
  report.outer = result.newton_steps;
  report.inner = result.increments;
  report.float64 = true;
  report.min_j = result.min_j;
  report.energy = result.energy;
  report.ms = 1e3 * watch.seconds();
  if (!result.converged)
    report.refusal = fmt::format(
        "--static: the last equilibrium found is that under a load factor of {:.4g} of 1",
        result.load_factor);
  return report;
}

}  // namespace

std::unique_ptr<Stepper> make_static_stepper(const Setup& setup, const AnimateOptions& options) {
  return std::make_unique<StaticStepper>(setup, options);
}

}  // namespace elastogen
