// SPDX-License-Identifier: Apache-2.0
// One time step of a scene: the state that minimises the incremental potential, with its
// certificate. A solver is built once a scene; a step allocates nothing of the grid's size.

#pragma once

#include "core/report.hpp"
#include "core/state.hpp"
#include "network/law/learned_law.hpp"

#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace elastogen {

/// quasi: L-BFGS whose first matrix is one V-cycle with encoder. newton: the Hessian in a
/// trust region, PCG with one V-cycle and encoder as preconditioner. auto: newton above Courant number 100 or Poisson ratio 0.47; else quasi, and where a step
/// takes it more than 20 evaluations (contact, buckling) the cheaper of the two by their own counts.
/// paper: the published algorithm with fixed loops, for study.
enum class SolverMode { kAuto, kQuasi, kNewton, kPaper };

std::string_view solver_name(SolverMode mode);
/// @throws Error naming the known modes.
SolverMode solver_from_name(std::string_view name);

/// Loops as the paper counts them.
struct PaperLoops {
  int outer = 10;  ///< R1, times that N and R are taken anew
  int inner = 20;  ///< Jacobi sweeps of each
  int modes = 54;  ///< latent size, three times the cosines; 0: no encoder
};

/// The machine that iterations run on. auto: the CUDA device if there is one and it has memory for
/// the scene, else the CPU.
enum class Device { kAuto, kCpu, kCuda };

struct SolverOptions {
  SolverMode mode = SolverMode::kAuto;
  Device device = Device::kCpu;
  double tolerance = 1e-3;  ///< of |grad Phi| / |M g_ref|
  /// Of steps of TimeScheme::kAuto, of the motion in dt (core/time_error.hpp).
  double time_error = 5e-3;
  /// Steps of kAuto far shorter than dt are solved to what their time error needs, where that is more
  /// than the tolerance: an equal residual moves a node by less the shorter the step.
  bool follows_time_error = true;
  int max_outer = 400;       ///< L-BFGS iterations, or Newton steps
  int max_inner = 400;       ///< PCG iterations of one Newton step
  PaperLoops paper = {};     ///< loops and modes of the paper mode
  LearnedLaws learned = {};  ///< nets of the scene's materials; missing or null: analytic
  bool skip = true;          ///< false: float64 and encoder always, whatever the scene needs
  /// Polled once an iteration; where it says true the step is given up and the state stays.
  std::function<bool()> interrupted = [] { return false; };
};

/// |M g_ref| = 9.81 m/s^2 times the 2-norm of the masses over free nodes and components [N].
double reference_force(const Scene& scene);

/// Elastic Courant number (dt/h) sqrt(E/rho), the largest of the scene's materials.
double courant_number(const Scene& scene);

/// Estimate of the residual at which an iteration with float voxel maths ends,
///
///     1.5 2^-23 3K / (rho g_ref h):
///
/// stretches carry an error of about 2^-23, which the bulk modulus turns into forces. Measured
/// within a factor of 2 (tests/solver_test.cpp). Above a third of the tolerance a step runs
/// in float64.
double float_floor(const Scene& scene);

struct Embedding;

/// How the points of an asset have moved (voxelize/embedding.hpp).
struct CarriedFrame {
  const double* displacement = nullptr;  ///< [m], (points, 3)
  const double* gradient = nullptr;      ///< deformation gradient, row-major, (points, 9); null
                                         ///< unless asked for
};

class Solver {
 public:
  /// The scene must be finished and outlive the solver.
  /// @throws Error (usage) if the device is asked for and the scene or the mode is not one for it,
  /// (device) if there is none.
  Solver(const Scene& scene, const SolverOptions& options);
  ~Solver();

  /// Advances the state by dt; with TimeScheme::kAuto by a step within dt, of which the report tells
  /// the length and whether dt is complete. If the result is not finite the state stays as it was and the report
  /// says so. Same bits on every run and any number of threads.
  /// @throws Error if the state is not one of this scene or holds a number that is not finite.
  StepReport step(State& state);

  /// Steps of a clip, whose state stays on the machine where they run: begin() copies it there,
  /// advance() makes a step as step() does, read() fills a state or its positions, with time and
  /// step count. step() ends the clip.
  /// @throws Error as step; advance() and read() without begin().
  void begin(const State& state);
  StepReport advance();
  void read(State& state, StateParts parts = StateParts::kAll) const;

  /// Of the clip's last step, where that was made by stages; else empty.
  StageData stage_data() const;

  /// Largest |x| of a component in a clip [m].
  /// @throws Error without begin().
  double reach() const;

  /// Frames of a clip: carry takes the points, start_frame() makes a frame of the state and gives
  /// its number, which counts from 0, take_frame() waits for one of the last two. Where steps run
  /// on a card frames are made there, and come from it beside the steps that follow. The bits are
  /// those of deform_asset and deformation_gradient. Frames may be taken on another thread; they
  /// are valid until the second start_frame() after their own.
  /// @param embedding  in the scene's grid; must outlive the clip.
  /// @throws Error for another embedding, without begin() or carry(), and for another number.
  void carry(const Embedding& embedding, bool with_gradient);
  int64_t start_frame();
  CarriedFrame take_frame(int64_t number) const;

  /// Gradient of the incremental potential at the last state [N], (nodes, 3), 0 on pinned nodes;
  /// its norm is the residual of the report. Zero before the first step.
  Span<const double> residual() const;

  /// The mode that `auto` has come to.
  SolverMode mode() const;

  /// Name of the card that iterations run on, or "cpu".
  std::string device() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen
