// SPDX-License-Identifier: Apache-2.0
#include "scene/static_stepper.hpp"

#include "core/stopwatch.hpp"
#include "mpm_fem/integrators/static_fem.hpp"
#include "scene/fem_holders.hpp"
#include "scene/fem_scene.hpp"
#include "scene/host_stepper.hpp"

#include <fmt/format.h>

namespace elastogen {
namespace {

class StaticStepper : public HostStepper {
 public:
  StaticStepper(const Setup& setup, const RunDescription& run)
      : HostStepper(setup.scene.grid),
        setup_(setup),
        run_(run),
        scene_(fem_scene(setup, run)),
        holders_(setup, run, scene_),
        residual_(scene_.mesh.rest.rows(), 3) {}

  void begin(const StartMotion&) override {
    state_ = {};
    state_.x = scene_.mesh.rest;
    state_.v = Array<double>(state_.x.rows(), 3);
  }
  StepReport advance() override;
  Span<const double> residual() const override { return residual_; }
  std::optional<StatePlastic> plastic() const override { return state_plastic(scene_, plastic_); }
  void describe(StateHeader& header) const override {
    describe_fem(setup_, run_, scene_, header);
    header.scheme = "static";
  }

 private:
  const Setup& setup_;
  const RunDescription& run_;
  fem::FemScene scene_;
  FemHolders holders_;
  fem::PlasticHistory plastic_;
  Array<double> residual_;  ///< of the last step [N], (nodes, 3)
};

StepReport StaticStepper::advance() {
  const Stopwatch watch;
  // the equilibrium, or the last one found under a part of the load
  fem::StaticResult result = fem::solve_static(scene_, {.tolerance = fem_tolerance(setup_, run_)});
  for (int64_t k = 0; k < state_.x.size(); ++k)
    state_.x.data()[k] = scene_.mesh.rest.data()[k] + result.u.data()[k];
  state_.time = result.load_factor;
  ++state_.steps;
  residual_ = std::move(result.gradient);
  plastic_ = std::move(result.plastic);
  // its report: outer counts Newton steps, inner load increments
  StepReport report;
  report.step = state_.steps;
  report.time = state_.time;
  report.converged = result.converged;
  report.residual = result.residual;
  report.outer = result.newton_steps;
  report.inner = result.increments;
  report.float64 = true;
  report.yields = !scene_.yields.empty();
  report.min_j = result.min_j;
  report.energy = result.energy;
  report.reactions = holders_.reactions(result);
  report.ms = 1e3 * watch.seconds();
  // a draft says how far it came
  if (!result.converged)
    report.refusal = fmt::format(
        "--static: the last equilibrium found is that under a load factor of {:.4g} of 1",
        result.load_factor);
  return report;
}

}  // namespace

std::unique_ptr<Stepper> make_static_stepper(const Setup& setup, const RunDescription& run) {
  return std::make_unique<StaticStepper>(setup, run);
}

}  // namespace elastogen
