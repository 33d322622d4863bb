// SPDX-License-Identifier: Apache-2.0
#include "scene/fem_stepper.hpp"

#include "mpm_fem/integrators/parted_fem.hpp"
#include "mpm_fem/integrators/stage_fem.hpp"
#include "scene/fem_boundary.hpp"
#include "scene/fem_holders.hpp"
#include "scene/fem_scene.hpp"
#include "scene/host_stepper.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr int kMostOfPart = 40;  // Newton steps of a part of a step before it is halved

/// a - b, entry by entry.
Array<double> difference(const Array<double>& a, const Array<double>& b) {
  Array<double> result = a;
  for (int64_t k = 0; k < a.size(); ++k) result.data()[k] -= b.data()[k];
  return result;
}

class FemStepper : public HostStepper {
 public:
  FemStepper(const Setup& setup, const RunDescription& run, std::function<bool()> stop)
      : HostStepper(setup.scene.grid),
        setup_(setup),
        run_(run),
        stop_(std::move(stop)),
        scene_(fem_scene(setup, run)),
        holders_(setup, run, scene_) {
    const fem::ImplicitOptions options{.tolerance = fem_tolerance(setup, run),
                                       .max_newton = scene_.yields.empty() ? 100 : kMostOfPart,
                                       .as_positions = true};
    if (has_stages(setup.scene.scheme))
      stages_.emplace(scene_,
                      fem::StageOptions{.solve = options,
                                        .time_error = run.solver.time_error,
                                        .follows_time_error = run.solver.follows_time_error});
    else
      solver_.emplace(scene_, options);
  }

  void begin(const StartMotion& motion) override;
  void begin_at(const State& state) override;
  StepReport advance() override;
  Span<const double> residual() const override {
    return stages_ ? stages_->residual() : solver_->residual();
  }
  void describe(StateHeader& header) const override {
    describe_fem(setup_, run_, scene_, header);
    if (run_.fem->newmark) header.scheme = "newmark";
  }
  std::optional<StatePlastic> plastic() const override;
  StageData stage_data() const override {
    StageData data;
    if (scene_.force || scene_.in_wind) data.load = loads();
    if (!stages_) return data;
    data.first = first_, data.bonds = fem_.stages.bonds, data.first_load = stages_->first_loads();
    return data;
  }

 private:
  void show();
  const Array<double>& loads() const { return stages_ ? stages_->loads() : solver_->loads(); }
  const fem::Potential& potential() const {
    return stages_ ? stages_->potential() : solver_->potential();
  }

  const Setup& setup_;
  const RunDescription& run_;
  std::function<bool()> stop_;
  fem::FemScene scene_;
  FemHolders holders_;
  std::optional<fem::ImplicitFem> solver_;  // or
  std::optional<fem::StageFem> stages_;
  fem::FemState fem_;    ///< state of the solver; state_ is the same as positions
  Array<double> first_;  ///< positions at the end of the first stage of SDIRK2 [m], (nodes, 3)
};

void FemStepper::begin(const StartMotion& motion) {
  Scene nodes;  // only the members that initial_state reads
  nodes.grid.rest = scene_.mesh.rest;
  nodes.mass = potential().mass().nodal();
  nodes.pinned = nodes_with_holders(setup_, scene_.mesh).pinned;
  State state = initial_state(nodes, motion);
  for (int64_t k = 0; k < state.v.size(); ++k)
    if (scene_.fixed.data()[k]) state.v.data()[k] = 0;
  scene_.dependent.fill(state.v.data());
  // what moves stands at the start of its path
  Array<double> u(state.x.rows(), 3);
  u = fem::with_motion(scene_, 0, u);
  const Array<double> offset = fem::dependent_offset(scene_, 0);
  const double soon = 1e-3 * scene_.dt;
  const Array<double> next = fem::dependent_offset(scene_, soon);
  for (int64_t i = 0; i < offset.rows(); ++i)
    for (int d = 0; d < 3; ++d) {
      u(scene_.dependent.node(i), d) = offset(i, d);
      state.v(scene_.dependent.node(i), d) += (next(i, d) - offset(i, d)) / soon;
    }
  for (int64_t k = 0; k < u.size(); ++k) state.x.data()[k] += u.data()[k];
  begin_at(state);
}

void FemStepper::begin_at(const State& state) {
  HostStepper::begin_at(state);
  fem_ = {};
  fem_.u = difference(state.x, scene_.mesh.rest);
  fem_.v = state.v;
  if (!state.x_before.empty()) {
    fem_.u_before = difference(state.x_before, scene_.mesh.rest);
    fem_.v_before = state.v_before;
  }
  fem_.stages.h_before = state.h_before;
  fem_.time = state.time;
  fem_.steps = state.steps;
}

std::optional<StatePlastic> FemStepper::plastic() const {
  return state_plastic(scene_, fem_.plastic);
}

StepReport FemStepper::advance() {
  StepReport report;
  report.interrupted = stop_();
  if (report.interrupted) return report;
  if (stages_)
    report = stages_->step(fem_, stop_);
  else if (scene_.yields.empty())
    report = solver_->step(fem_);
  else
    report = step_in_parts(*solver_, fem_, stop_);
  if (!report.finite || report.interrupted) return report;
  show();
  report.reactions = holders_.reactions(stages_ ? stages_->holding() : solver_->holding(), loads(),
                                        fem_.u, fem_.time);
  return report;
}

/// Copies positions, velocities and time to state_.
void FemStepper::show() {
  std::swap(state_.x_before, state_.x);
  std::swap(state_.v_before, state_.v);
  const int64_t count = fem_.u.size();
  const Array<double>& rest = scene_.mesh.rest;
  if (state_.x.size() != count) state_.x = state_.v = Array<double>(rest.rows(), 3);
  for (int64_t k = 0; k < count; ++k) state_.x.data()[k] = rest.data()[k] + fem_.u.data()[k];
  std::copy_n(fem_.v.data(), count, state_.v.data());
  if (stages_ && !stages_->first_stage().empty()) {
    first_ = rest;
    for (int64_t k = 0; k < count; ++k) first_.data()[k] += stages_->first_stage().data()[k];
  }
  state_.h_before = fem_.stages.h_before;
  state_.time = fem_.time;
  state_.steps = fem_.steps;
}

}  // namespace

std::unique_ptr<Stepper> make_fem_stepper(const Setup& setup, const RunDescription& run,
                                          std::function<bool()> stop) {
  return std::make_unique<FemStepper>(setup, run, std::move(stop));
}

}  // namespace elastogen
