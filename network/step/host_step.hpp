// SPDX-License-Identifier: Apache-2.0
// Steps on the host (step_work.hpp).

#pragma once

#include "network/paper/paper_solver.hpp"
#include "network/step/free_flight.hpp"
#include "network/step/host_frames.hpp"
#include "network/step/host_stage_machine.hpp"
#include "network/step/newton_solver.hpp"
#include "network/step/predictor.hpp"
#include "network/step/quasi_solver.hpp"
#include "network/step/stages.hpp"
#include "network/step/step_work.hpp"

#include <optional>

namespace elastogen {

class HostStep : public StepWork {
 public:
  /// @param arguments  as make_host_step.
  HostStep(PotentialTerms&& terms, const EncoderChoice* encoder, const PaperLoops& loops,
           bool in_float);

  std::string machine() const override { return "cpu"; }
  void upload(const State& state) override;
  void download(State& state, StateParts parts) override;
  void borrow(State& state) override;
  void give_back(State&) override { state_ = &own_; }
  double reach() override;

  void begin_step(const StepScheme& scheme, double time) override;
  void evaluate_starts(int count, double* phi) override;
  void use_start(int start) override;
  double farthest() override;
  const Collider* clear_start() override;
  bool meets_collider() override { return is_cut_ && stages_.value().flies_fast(); }
  bool is_below_clear_start() override { return rough_phi(u_) < rough_phi(clear_); }
  void return_to_clear_start() override { u_ = clear_; }
  void set_nodal_rotations() override { potential_.set_nodal_rotations(u_.data()); }

  IterationResult quasi(double target, int max_outer, double precise_below,
                        const Interrupted& interrupted) override;
  IterationResult newton(double target, int max_outer, int max_inner,
                         const Interrupted& interrupted) override;
  IterationResult paper(const Interrupted& interrupted) override {
    return paper_.value().solve(u_.data(), interrupted);
  }
  double phi() override { return phi_at(u_); }
  double phi_now() override { return phi_at(now_held()); }
  void return_to_now() override { u_ = now_held(); }

  Certificate certify() override;
  double least_motion(double interval) override {
    return stages_.value().least_motion(state_->v.data(), interval);
  }
  bool renew_lags() override;
  void relax_lags(double share) override {
    if (potential_.loads().blows()) potential_.relax_wind();
    Contact& contact = potential_.contact();
    if (share < 1 && scheme_.is_stage && contact.exists()) contact.relax_lag(share);
  }
  void keep_stage() override;
  StageData stage_data() override;
  StageEnd end_step(const TimeErrorOptions* options) override;
  MotionEnergy finish() override;
  void download_gradient(double* gradient) const override {
    std::copy(gradient_.begin(), gradient_.end(), gradient);
  }

  void upload_u(const double* u) override { std::copy(u, u + u_.size(), u_.begin()); }
  void download_u(double* u) override { std::copy(u_.begin(), u_.end(), u); }

  void carry(const Embedding& embedding, bool with_gradient) override {
    frames_.emplace(scene_.grid, embedding, with_gradient);
  }
  void start_frame(int slot) override { frames_->make(slot, state_->x); }
  CarriedFrame take_frame(int slot) const override { return frames_->get(slot); }

 private:
  template <class T, class P>
  IterationResult quasi(std::unique_ptr<QuasiSolver<T>>& solver, double target, int max_outer,
                        Preconditioner<P>& first, const Interrupted& interrupted);
  double phi_at(const Zeroed<double>& u);
  const Zeroed<double>& now_held();
  double rough_phi(const Zeroed<double>& u);
  bool touches();
  bool balance();
  void round_positions();
  void conserve_momentum(Array<double>& v);
  Array<double> next_velocities() const;
  void begin_stage();
  void open_ledger(const double* motion);
  void forget();
  void filter(double interval, double* y);
  template <class P>
  void filter(Preconditioner<P>& first, double interval, double* y);

  const Scene& scene_;
  IncrementalPotential potential_;
  Predictor predictor_;
  FreeFlight flight_;
  StepScheme scheme_;
  State own_;             // of a clip
  State* state_ = &own_;  // the present one: that, or one that is borrowed
  Zeroed<double> u_, gradient_;
  Zeroed<double> clear_;                           // the clear start
  Zeroed<double> now_held_;                        // by now_held
  std::vector<Zeroed<double>> starts_;             // extrapolations, from order 1 on
  Zeroed<double> u_before_shift_;                  // by balance
  Array<double> x_, v_;                            // of the new state; v_ of steps of stages
  Array<double> first_load_;                       // at the end of SDIRK2's first stage
  std::optional<HostStageMachine> stage_machine_;  // where the scene's scheme has some
  std::optional<Stages> stages_;
  StageCertificate certificate_;  // the last one
  bool is_cut_ = false;           // by clear_start
  bool in_flight_ = false;        // free pieces are there, and nothing touches

  // where float has too few digits for the scene, the preconditioner in double; else that in float
  std::optional<Preconditioner<float>> single_;
  std::optional<Preconditioner<double>> precise_;
  // from their first use on
  std::unique_ptr<QuasiSolver<float>> quasi_float_;
  std::unique_ptr<QuasiSolver<double>> quasi_double_;
  std::unique_ptr<NewtonSolver> newton_;
  std::optional<PaperSolver> paper_;
  std::optional<HostFrames> frames_;
};

}  // namespace elastogen
