// SPDX-License-Identifier: Apache-2.0
// The time error that a run of the network says of each frame, beside the one that it makes there.
//
//   bench_local_error STEPS animate ASSET ... [OPTIONS of animate]
//
// Each frame is made again from where the run began it, by STEPS equal steps of SDIRK2. Prints a line of
// JSON a frame, lengths in metres, rms over the mass of a piece, the largest of the pieces:
//
//     estimate             sum over the steps of the frame: what the run says
//     accepted             what it allows in a frame, by the speeds at its start and its end
//     error                of the positions at the end of the frame
//     shown                the same behind the filter S of core/time_error.hpp, which the estimate has too
//     kick                 the rigid part of that of the velocities of free pieces, times the frame, where a
//                          collider struck one by more than the speed of a bounce that the estimate counts; else 0
//     touches              a collider acted on the body
//
// The bonds of friction are no part of a state. Where the frame before touched a collider, both ways start
// without them, and estimate and error are of the frame that the run makes so.

#include "cli/options.hpp"
#include "core/error.hpp"
#include "core/pcg.hpp"
#include "core/time_error.hpp"
#include "network/potential/incremental_potential.hpp"
#include "network/precondition/preconditioner.hpp"
#include "network/step/piece_sums.hpp"
#include "scene/asset_stages.hpp"
#include "scene/stepper.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <cstdio>

namespace elastogen::bench {
namespace {

constexpr int kMostIterations = 1000;
constexpr double kFine = 1e-3;  // residual of the filter, of the right-hand side

/// A run with its scene.
struct Run {
  AnimateOptions options;
  Setup setup;
  std::unique_ptr<Stepper> stepper;

  Run(const Asset& asset, const AnimateOptions& of) : options(of), setup(set_up(asset, options)) {
    std::vector<std::string> notes;
    stepper = make_stepper(setup, options, {}, notes);
  }
};

/// S of core/time_error.hpp at a state.
class Filter {
 public:
  explicit Filter(const Scene& scene, double interval)
      : scene_(scene), interval_(interval), potential_(scene) {}

  void apply(const State& at, Array<double>& y) {
    // the Hessian with the colliders where they are now
    State still = at;
    still.v.fill(0);
    still.x_before = still.v_before = {};
    still.time -= interval_;
    potential_.begin_step(still, {TimeScheme::kEuler, interval_, 1});
    Array<double> u(y.rows(), 3);
    for (int64_t k = 0; k < u.size(); ++k)
      u.data()[k] = at.x.data()[k] - scene_.grid.rest.data()[k];
    potential_.set_nodal_rotations(u.data());
    potential_.linearise(u.data());
    if (!first_) first_.emplace(potential_, EncoderChoice{false});
    first_->update_inertia();
    first_->update_contact();
    // in float, scaled to 1
    const int64_t size = y.size();
    double most = 0;
    for (int64_t k = 0; k < size; ++k) most = std::max(most, std::abs(weight(k) * y.data()[k]));
    if (most == 0) return;
    std::vector<float> right(static_cast<size_t>(size)), found(right);
    for (int64_t k = 0; k < size; ++k) right[size_t(k)] = float(weight(k) * y.data()[k] / most);
    potential_.held().fold(right.data());
    PcgWork<float> work(size);
    const PcgResult end = pcg(
        right.data(), found.data(), size, kFine, kMostIterations, work,
        [&](const float* p, float* Ap) { potential_.hessian_product(p, Ap); },
        [&](const float* r, float* z) { first_->apply(r, z); });
    ELASTOGEN_CHECK(end.converged, "the filter does not converge: ", end.residual);
    for (int64_t k = 0; k < size; ++k) y.data()[k] = most * double(found[size_t(k)]);
  }

 private:
  double weight(int64_t k) const { return potential_.inertia(k / 3); }

  const Scene& scene_;
  double interval_;
  IncrementalPotential potential_;
  std::optional<Preconditioner<float>> first_;
};

/// rms of a field over the mass of a piece, of the piece where it is largest.
double largest_rms(const Pieces& pieces, const Scene& scene, const Array<double>& y) {
  double most = 0;
  for (size_t p = 0; p < pieces.count(); ++p) {
    const auto sum = pieces.sum<1>(p, [&](int64_t n, auto& part) {
      for (int d = 0; d < 3; ++d) part[0] += scene.mass(n) * y(n, d) * y(n, d);
    });
    most = std::max(most, std::sqrt(sum[0] / pieces.mass(p)));
  }
  return most;
}

Vec3 row(const Array<double>& values, int64_t n) {
  return {values(n, 0), values(n, 1), values(n, 2)};
}

/// A piece at positions x with velocities v.
PieceState state_of(const Pieces& pieces, size_t p, const Scene& scene, const Array<double>& x,
                    const Array<double>& v) {
  // centre and momentum, then angular momentum and moments about it
  const auto first = pieces.sum<6>(p, [&](int64_t n, auto& part) {
    for (int d = 0; d < 3; ++d) {
      part[size_t(d)] += scene.mass(n) * x(n, d);
      part[size_t(3 + d)] += scene.mass(n) * v(n, d);
    }
  });
  PieceState state;
  for (size_t d = 0; d < 3; ++d) {
    state.centre[d] = first[d] / pieces.mass(p);
    state.velocity[d] = first[3 + d] / pieces.mass(p);
  }
  const auto second = pieces.sum<9>(p, [&](int64_t n, auto& part) {
    const Vec3 r = minus(row(x, n), state.centre), spin = cross(r, row(v, n));
    for (size_t d = 0; d < 3; ++d) {
      part[d] += scene.mass(n) * spin[d];
      part[3 + d] += scene.mass(n) * r[d] * r[d];
      part[6 + d] += scene.mass(n) * r[d] * r[(d + 1) % 3];
    }
  });
  for (size_t d = 0; d < 3; ++d) {
    const int a = int(d), b = int((d + 1) % 3);
    state.spin[d] = second[d];
    state.inertia(a, a) = second[3 + (d + 1) % 3] + second[3 + (d + 2) % 3];
    state.inertia(a, b) = state.inertia(b, a) = -second[6 + d];
  }
  return state;
}

/// rms of the rigid part of velocities over the mass of a free piece, of the piece where it is largest.
double largest_rigid_rms(const Pieces& pieces, const Scene& scene, const Array<double>& x,
                         const Array<double>& v) {
  double most = 0;
  for (size_t p = 0; p < pieces.count(); ++p) {
    if (!pieces.is_free(p)) continue;
    const PieceState state = state_of(pieces, p, scene, x, v);
    const double square =
        dot(state.velocity, state.velocity) + pieces.spin_square(p, state) / pieces.mass(p);
    most = std::max(most, std::sqrt(square));
  }
  return most;
}

/// Makes a frame. @throws Error where a step has no result.
nlohmann::ordered_json make_frame(Run& run) {
  double estimate = 0, ratio = 0;
  int64_t steps = 0, solves = 0, rejected = 0;
  Vec3 impulse = {};
  for (int part = 0; part < run.setup.substeps; ++steps) {
    const StepReport r = run.stepper->advance();
    ELASTOGEN_CHECK(r.finite && !r.interrupted, "step ", r.step, " has no result");
    part += r.completes;
    solves += r.solves, rejected += r.rejected;
    estimate += r.time_error;
    ratio = std::max(ratio, r.time_ratio);
    impulse = plus(impulse, r.ledger.done.contact.linear);
  }
  return {{"steps", steps},       {"solves", solves}, {"rejected", rejected},
          {"estimate", estimate}, {"ratio", ratio},   {"touches", safe_norm(impulse) > 0},
          {"impulse", impulse}};
}

/// Each frame of a run, and the same again.
class Comparison {
 public:
  Comparison(const Asset& asset, const AnimateOptions& options, const AnimateOptions& of_fine)
      : run_(asset, options),
        again_(asset, options),
        fine_(asset, of_fine),
        scene_(run_.setup.scene),
        interval_(1 / options.fps),
        filter_(scene_, interval_),
        pieces_(scene_) {
    run_.stepper->begin(options.motion);
  }

  nlohmann::ordered_json next_frame(int64_t frame) {
    // by the run, and in fine steps from the same start
    State start = run_.stepper->state();
    start.x_before = start.v_before = {};
    nlohmann::ordered_json line = {{"frame", frame}};
    line.update(make_frame(run_));
    fine_.stepper->begin_at(start);
    make_frame(fine_);
    if (touched_) {
      again_.stepper->begin_at(start);
      const nlohmann::ordered_json made = make_frame(again_);
      for (const char* key : {"estimate", "ratio"}) line[key] = made[key];
    }
    line["accepted"] = accepted(start, run_.stepper->state(), line["touches"]);
    add_errors((touched_ ? again_ : run_).stepper->state(), line);
    touched_ = line["touches"];
    return line;
  }

 private:
  /// What a frame may add to the time error, of the piece where it is least [m].
  double accepted(const State& start, const State& end, bool touches) const {
    double least = 1e300;
    for (size_t p = 0; p < pieces_.count(); ++p) {
      double speed = 0;
      for (const State* at : {&start, &end}) {
        const auto square = pieces_.sum<1>(p, [&](int64_t n, auto& part) {
          for (int d = 0; d < 3; ++d) part[0] += scene_.mass(n) * at->v(n, d) * at->v(n, d);
        });
        const double m = pieces_.mass(p), whole = square[0] / m;
        const double spin =
            pieces_.is_loose(p)
                ? pieces_.spin_square(p, state_of(pieces_, p, scene_, at->x, at->v)) / m
                : 0;
        const double rest = std::sqrt(std::max(whole - spin, 0.0));
        speed = std::max(speed, counted_speed(rest, std::sqrt(spin), touches));
      }
      least = std::min(least, std::max(interval_ * speed, kMotionFloor * pieces_.size(p)));
    }
    return run_.options.solver.time_error * least;
  }

  /// Whether the impulse of a frame beyond the weight is that of a bounce that counts, for some piece.
  bool was_struck(const Vec3& impulse) const {
    double mass = 0;
    for (size_t p = 0; p < pieces_.count(); ++p) mass += pieces_.mass(p);
    const double beyond = safe_norm(plus(impulse, scaled(scene_.gravity, mass * interval_)));
    for (size_t p = 0; p < pieces_.count(); ++p)
      if (beyond > 0 && bounce_counts(beyond / pieces_.mass(p), safe_norm(scene_.gravity),
                                      interval_, pieces_.size(p)))
        return safe_norm(impulse) > 0;
    return false;
  }

  /// The difference to the fine steps, as it is and as a frame shows it.
  void add_errors(const State& end, nlohmann::ordered_json& line) {
    const State& exact = fine_.stepper->state();
    Array<double> error(end.x.rows(), 3), of_velocity(end.x.rows(), 3);
    for (int64_t k = 0; k < error.size(); ++k) {
      error.data()[k] = end.x.data()[k] - exact.x.data()[k];
      of_velocity.data()[k] = end.v.data()[k] - exact.v.data()[k];
    }
    line["error"] = largest_rms(pieces_, scene_, error);
    filter_.apply(end, error);
    line["shown"] = largest_rms(pieces_, scene_, error);
    const bool struck = was_struck(line["impulse"]);
    line["kick"] = struck ? interval_ * largest_rigid_rms(pieces_, scene_, end.x, of_velocity) : 0;
  }

  Run run_, again_, fine_;
  const Scene& scene_;
  double interval_;
  Filter filter_;
  Pieces pieces_;
  bool touched_ = false;  // a collider, in the frame before
};

int local_error(int argc, char** argv) {
  const int steps = argc > 2 ? std::atoi(argv[1]) : 0;
  if (steps < 1) {
    fmt::print(stderr, "usage: bench_local_error STEPS animate ASSET ...\n");
    return 2;
  }
  const CommandLine line = parse_command_line(argc - 1, argv + 1);
  if (!line.animate) return line.code;
  AnimateOptions fine = *line.animate;
  fine.scheme = TimeScheme::kSdirk2;
  fine.substeps = steps;
  const Asset asset = run_asset(*line.animate);
  Comparison comparison(asset, *line.animate, fine);
  for (int64_t frame = 1; frame <= line.animate->frames; ++frame) {
    fmt::print("{}\n", comparison.next_frame(frame).dump());
    std::fflush(stdout);
  }
  return 0;
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  try {
    return elastogen::bench::local_error(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "bench_local_error: {}\n", error.what());
    return 1;
  }
}
