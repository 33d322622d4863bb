// SPDX-License-Identifier: Apache-2.0
// What a solver is built of, and its public face.
#include "network/solver.hpp"

#include "core/cuda/card.hpp"
#include "core/error.hpp"
#include "core/stopwatch.hpp"
#include "network/paper/paper_solver.hpp"
#include "network/step/solver_impl.hpp"
#include "voxelize/embedding.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kDoubleCourant = 1000;  // everything in float64
constexpr double kEncoderCourant = 2;    // below it multigrid alone does as well,
constexpr double kEncoderSoftness = 5;  // and below it too: beams and balls take as many iterations

void check_options(const SolverOptions& o) {
  ELASTOGEN_CHECK(o.tolerance > 0 && std::isfinite(o.tolerance),
                  "the tolerance must be positive, got ", o.tolerance);
  ELASTOGEN_CHECK(o.time_error > 0 && std::isfinite(o.time_error),
                  "the time error must be positive, got ", o.time_error);
  ELASTOGEN_CHECK(o.max_outer >= 0 && o.max_inner >= 0, "iteration limits must not be negative, ",
                  "got ", o.max_outer, " and ", o.max_inner);
}

/// Tables are built for the scheme of the run.
StepScheme scheme_of_run(const Scene& scene) {
  double a0 = 1;
  if (scene.scheme == TimeScheme::kBdf2 || scene.scheme == TimeScheme::kAuto) a0 = 2.25;
  if (scene.scheme == TimeScheme::kSdirk2) a0 = 1 / (kSdirkStage * kSdirkStage);
  return {scene.scheme, scene.dt, a0};
}

}  // namespace

Solver::Impl::Impl(const Scene& s, const SolverOptions& o)
    : scene(s),
      options(o),
      terms(std::in_place, s, o.learned, scheme_of_run(s)),
      force(reference_force(s)),
      courant(courant_number(s)),
      mode(o.mode),
      gradient(3 * size_t(s.grid.node_count())) {
  check_options(o);
  pinned = !s.fixed.empty() || std::any_of(s.pinned.data(), s.pinned.data() + s.pinned.rows(),
                                           [](uint8_t p) { return p != 0; });
  extrapolates = pinned || !s.colliders.empty();
  std::fill(std::begin(last_step), std::end(last_step), -kRetry);
  if (mode == SolverMode::kAuto) mode = is_stiff() ? SolverMode::kNewton : SolverMode::kQuasi;

  ELASTOGEN_CHECK(mode != SolverMode::kPaper || !has_stages(s.scheme),
                  "the paper's algorithm has no steps of stages: --time-scheme euler or bdf2");
  ELASTOGEN_CHECK(mode != SolverMode::kPaper || !terms->has_damping(),
                  "the paper's algorithm has no damping: --damping 0");
  ELASTOGEN_CHECK(mode != SolverMode::kPaper || scene.dependent.empty(),
                  "the paper's algorithm knows no dependent nodes");
  ELASTOGEN_CHECK(mode != SolverMode::kPaper || scene.fixed.empty(),
                  "the paper's algorithm knows no holds along single axes");
  ELASTOGEN_CHECK(mode != SolverMode::kPaper || !s.wind.blows(),
                  "the paper's algorithm knows no wind");
  if (mode == SolverMode::kPaper) {
    check_paper_scene(*terms, o.paper);
    in_float = true;
    make_work(nullptr);
    return;
  }
  // forces beyond the range of float, or conditions beyond its digits
  in_float = courant <= kDoubleCourant && force < 1e25 && force > 1e-25;
  // contact may ask for what rest does not; modes of the encoder know no fixed components
  const EncoderChoice encoder{scene.fixed.empty() && (!o.skip || courant > kEncoderCourant),
                              o.skip && scene.colliders.empty() ? kEncoderSoftness : 0};
  make_work(&encoder);
}

/// On the card where it is asked for or chosen, else on the host.
void Solver::Impl::make_work(const EncoderChoice* encoder) {
  const bool asked = options.device == Device::kCuda;
  const bool wanted = asked || (options.device == Device::kAuto && in_float && cuda::has_device());
  if (asked && !cuda::has_device())
    throw Error("there is no CUDA device, or none that this build can use: leave out --device cuda",
                ErrorKind::kDevice);
  ELASTOGEN_CHECK(!asked || in_float,
                  "the device cannot take the scene: float has too few digits for it");
  try {
    if (wanted) work = cuda::make_device_step(*terms, encoder, options.paper);
  } catch (const Error& error) {  // too little memory there: auto goes on here
    if (asked || error.kind() != ErrorKind::kResources) throw;
  }
  if (!work) work = make_host_step(std::move(*terms), encoder, options.paper, in_float);
}

Solver::Solver(const Scene& scene, const SolverOptions& options)
    : impl_(std::make_unique<Impl>(scene, options)) {}

Solver::~Solver() = default;

SolverMode Solver::mode() const {
  return impl_->mode;
}

std::string Solver::device() const {
  return impl_->work->machine();
}

Span<const double> Solver::residual() const {
  return impl_->residual();
}

void Solver::begin(const State& state) {
  Impl& s = *impl_;
  check_state(state, s.scene.grid.node_count());
  s.work->upload(state);
  s.begin(state);
  s.in_clip = true;
}

StepReport Solver::advance() {
  ELASTOGEN_CHECK(impl_->in_clip, "advance() comes after begin()");
  return impl_->advance();
}

void Solver::read(State& state, StateParts parts) const {
  const Impl& s = *impl_;
  ELASTOGEN_CHECK(s.in_clip, "read() comes after begin()");
  s.work->download(state, parts);
  state.time = s.time;
  state.steps = s.steps;
}

StageData Solver::stage_data() const {
  return impl_->work->stage_data();
}

StepReport Solver::step(State& state) {
  Impl& s = *impl_;
  const Stopwatch watch;
  check_state(state, s.scene.grid.node_count());
  s.in_clip = false;
  s.begin(state);
  s.work->borrow(state);
  StepReport report = s.advance();
  s.work->give_back(state);
  state.time = s.time;
  state.steps = s.steps;
  report.ms = watch.milliseconds();
  return report;
}

double Solver::reach() const {
  ELASTOGEN_CHECK(impl_->in_clip, "reach() comes after begin()");
  return impl_->work->reach();
}

void Solver::carry(const Embedding& embedding, bool with_gradient) {
  Impl& s = *impl_;
  const int64_t points = embedding.voxel.rows(), voxels = s.scene.grid.voxel_count();
  ELASTOGEN_CHECK(Span<const double>(embedding.weights).is(points, 8), "weights must be (", points,
                  ", 8), got ", Span<const double>(embedding.weights));
  for (int64_t p = 0; p < points; ++p)
    ELASTOGEN_CHECK(embedding.voxel(p) >= 0 && embedding.voxel(p) < voxels, "point ", p,
                    " lies in voxel ", embedding.voxel(p), " of ", voxels);
  s.work->carry(embedding, with_gradient);
  s.carries = true;
  s.frames = 0;
}

int64_t Solver::start_frame() {
  Impl& s = *impl_;
  ELASTOGEN_CHECK(s.in_clip && s.carries, "start_frame() comes after begin() and carry()");
  s.work->start_frame(int(s.frames % 2));
  return s.frames++;
}

CarriedFrame Solver::take_frame(int64_t number) const {
  const Impl& s = *impl_;
  const int64_t frames = s.frames;
  ELASTOGEN_CHECK(number >= 0 && number < frames && number >= frames - 2, "frame ", number,
                  " is not one of the last two of ", frames);
  return s.work->take_frame(int(number % 2));
}

}  // namespace elastogen
