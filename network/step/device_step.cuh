// SPDX-License-Identifier: Apache-2.0
// The step on the device and the state that stays there, for the files that make it up:
// predictor.cu (where iterations begin), device_stages.cu (stages), device_loads.cu (loads that change),
// device_step.cu (all else).

#pragma once

#include "core/cuda/card.hpp"
#include "core/cuda/signal.cuh"
#include "network/paper/paper_solver_device.hpp"
#include "network/step/device_motion.cuh"
#include "network/step/device_stage_machine.cuh"
#include "network/step/frames.cuh"
#include "network/step/free_flight.cuh"
#include "network/step/host_frames.hpp"
#include "network/step/newton_solver_device.hpp"
#include "network/step/quasi_solver_device.hpp"
#include "network/step/stages.hpp"

#include <optional>

namespace elastogen::cuda {

class StepOnDevice : public StepWork {
 public:
  /// @param encoder  of the first matrix; null: the published algorithm, without one.
  StepOnDevice(const PotentialTerms& terms, const EncoderChoice* encoder, const PaperLoops& loops);

  std::string machine() const override { return device_name(); }
  void upload(const State& state) override;
  void download(State& state, StateParts parts) override;
  void borrow(State& state) override;
  double reach() override;

  void begin_step(const StepScheme& scheme, double time) override;
  void evaluate_starts(int count, double* phi) override;
  void use_start(int start) override;
  double farthest() override;
  const Collider* clear_start() override;
  bool meets_collider() override {
    return potential().contact() && potential().contact()->share() < 1 &&
           stages_.value().flies_fast();
  }
  bool is_below_clear_start() override;
  void return_to_clear_start() override;
  void set_nodal_rotations() override;

  IterationResult quasi(double target, int max_outer, double precise_below,
                        const Interrupted& interrupted) override {
    return quasi_.solve(target, max_outer, precise_below, interrupted);
  }
  IterationResult newton(double target, int max_outer, int max_inner,
                         const Interrupted& interrupted) override {
    return newton_solver().solve(target, max_outer, max_inner, interrupted);
  }
  IterationResult paper(const Interrupted& interrupted) override {
    return paper_.value().solve(interrupted);
  }
  double phi() override { return phi_at(quasi_.u()); }
  double phi_now() override { return phi_at(now()); }
  void return_to_now() override { find_now(quasi_.u()); }

  Certificate certify() override;
  double least_motion(double interval) override {
    return stages_.value().least_motion(v_.data(), interval);
  }
  bool renew_lags() override;
  void relax_lags(double share) override;
  void keep_stage() override;
  StageEnd end_step(const TimeErrorOptions* options) override;
  StageData stage_data() override;
  MotionEnergy finish() override;
  void download_gradient(double* gradient) const override { gradient_.download(gradient); }

  void upload_u(const double* u) override;
  void download_u(double* u) override;

  void carry(const Embedding& embedding, bool with_gradient) override;
  void start_frame(int slot) override;
  CarriedFrame take_frame(int slot) const override {
    return frames_ ? frames_->take(slot) : host_frames_->get(slot);
  }

  /// Most bytes that steps allocate beyond those of the constructor.
  size_t later_bytes();

  // called by the above; kernels may not be started from private functions
  DevicePotential& potential() { return quasi_.potential(); }
  Motion motion();
  void begin_loads();
  void put_loads();
  void begin_stage();
  void open_ledger(double* now);
  void round_positions();
  bool balance();
  void extrapolate(int order, double* u);
  void find_now(double* u);
  const double* before();
  void find_velocities();
  void find_energies();
  void find_size();

 private:
  int64_t size() const { return x_.size(); }
  bool touches();
  /// Whether those of the new state are in v_next_ before it is finished.
  bool has_velocities();
  /// find_now() in the scratch of a gradient.
  const double* now() {
    find_now(gradient_.data());
    return gradient_.data();
  }
  double phi_at(const double* u);
  void copy(const double* from, double* to) const;
  double rough_phi(const double* u);
  DeviceNewton& newton_solver();
  void forget();
  void accept_stages();
  void send(const State& state);
  void send(const Array<double>& from, DeviceArray<double>& to);
  void fetch(const DeviceArray<double>& from, Array<double>& to);

  const Scene& scene_;
  DeviceQuasi quasi_;
  std::optional<DeviceNewton> newton_;  // from its first step on
  std::optional<DevicePaper> paper_;
  DevicePieces pieces_;
  DeviceArray<double> x_, v_, x_before_, v_before_;  // the state
  DeviceArray<double> v_next_;    // in flight, of stages, in wind, or where a holder moves
  DeviceArray<double> gradient_;  // of the certificate
  DeviceArray<SumScratch<Largest>> largest_;
  DeviceArray<SumScratch<Sums<2>>> pair_sums_;
  PinnedArray<StepNumbers> numbers_;
  Signal signal_;                         // of numbers_
  std::optional<PinnedChunks> chunks_;    // that arrays of the state go through, if any did
  std::unique_ptr<DeviceFrames> frames_;  // where the card has memory for them, else
  std::optional<HostFrames> host_frames_;
  Array<double> first_stage_, bonds_;  // of stage_data(), on the host
  HostLoads loads_;
  std::optional<DeviceStageMachine> stage_machine_;  // where the scene's scheme has some
  std::optional<Stages> stages_;
  StepScheme scheme_;
  double time_ = 0, h_before_ = 0;               // of the state [s]
  StageCertificate certificate_;                 // the last one
  bool has_before_ = false, in_flight_ = false;  // in_flight_: that of the certificate
  bool has_rotations_ = false;                   // the preconditioner has the nodal rotations of u
};

}  // namespace elastogen::cuda
