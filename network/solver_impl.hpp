// SPDX-License-Identifier: Apache-2.0
// What a solver holds, for the files that make it up: solver.cpp (modes), solver_step.cpp (a step),
// solver_frames.cpp.

#pragma once

#include "network/cheaper_of.hpp"
#include "network/device.hpp"
#include "network/free_flight.hpp"
#include "network/newton_solver.hpp"
#include "network/paper_solver.hpp"
#include "network/predictor.hpp"
#include "network/quasi_solver.hpp"
#include "network/solver.hpp"

#include <atomic>
#include <limits>
#include <optional>

namespace elastogen {

struct Solver::Impl {
  static constexpr double kAlways = std::numeric_limits<double>::infinity();  // in float64

  Impl(const Scene& s, const SolverOptions& o);

  bool stiff() const;
  void take_device(const EncoderChoice& encoder, bool in_float);
  IncrementalPotential& take_potential();

  // the modes, which improve u
  IterationResult iterate(double target, StepReport& report);
  IterationResult choose(double target, StepReport& report);
  double cost(const IterationResult& r) const;
  IterationResult iterate_and_learn(double target, StepReport& report);
  template <class T, class P>
  IterationResult quasi(std::unique_ptr<QuasiSolver<T>>& solver, double target,
                        std::optional<Preconditioner<P>>& first) {
    if (on_device)
      return on_device->solve(target, options.max_outer, sizeof(T) == 8 ? kAlways : 0,
                              options.interrupted);
    if (!solver) solver = std::make_unique<QuasiSolver<T>>(*potential);
    return solver->solve(u.data(), target, options.max_outer, *first, options.interrupted);
  }
  IterationResult newton(double target);

  // the parts of a step
  StepReport advance(State& state);
  const Collider* begin_step(const State& state);
  const Collider* start(const State& state);
  const Collider* start_on_device(int64_t step);
  double phi(const Zeroed<double>& at);
  double rough_phi(const Zeroed<double>& at);
  bool begins_by_extrapolation(int64_t step);
  void choose_start(const State& state);
  IterationResult retreat(double target);
  bool solve(const State& state, StepReport& report);
  void balance();
  Certificate measure(const State& state);
  void certify(const State& state, StepReport& report);
  void conserve_momentum(const State& state, Array<double>& v);
  MotionEnergy take_positions(State& state);
  void finish(State& state, StepReport& report);

  const Scene& scene;
  SolverOptions options;
  std::optional<PotentialTerms> terms;            // with a device, which has the tables
  std::optional<IncrementalPotential> potential;  // without
  Predictor predictor;
  FreeFlight flight;
  bool in_flight = false;  // free pieces are there, and nothing touches
  double force, courant;
  bool pinned = false;
  bool extrapolates = false;  // where the predictor is not always best; then
  std::vector<CheaperOf> starts = std::vector<CheaperOf>(4, CheaperOf(20));  // of each mode
  int way = 0;  // that a step starts, 0: extrapolations too
  SolverMode mode;
  double last_cost[4] = {};  // of each mode
  int64_t last_step[4];      // that it took
  // without a device
  std::optional<Preconditioner<float>> single;
  std::optional<Preconditioner<double>> precise;
  std::unique_ptr<QuasiSolver<float>> quasi_float;
  std::unique_ptr<QuasiSolver<double>> quasi_double;
  std::unique_ptr<NewtonSolver> newton_solver;
  std::optional<PaperSolver> paper;
  Zeroed<double> u, gradient, u_before_shift;
  Array<double> x;  // of the new state

  // with a device, which then holds u and the arrays of the state
  std::unique_ptr<cuda::DeviceStep> on_device;
  bool gradient_on_device = false;  // that of the certificate
  StepScheme scheme;

  // of a clip
  State clip;  // without arrays where the device has them
  bool in_clip = false;

  // of its frames
  void make_frame(int slot);
  const Embedding* embedding = nullptr;
  bool frames_on_device = false;
  std::atomic<int64_t> frames = 0;  // started
  struct Frame {
    Array<double> displacement, gradient;
  } frame[2];  // where the device does not make them
};

}  // namespace elastogen
