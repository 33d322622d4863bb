// SPDX-License-Identifier: Apache-2.0
#include "cli/run.hpp"

#include "cli/clip_frames.hpp"
#include "cli/fem_boundary.hpp"
#include "cli/fem_stepper.hpp"
#include "cli/progress.hpp"
#include "cli/signals.hpp"
#include "cli/stepper.hpp"
#include "cli/still.hpp"
#include "cli/version.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/stopwatch.hpp"
#include "io/output_findings.hpp"
#include "io/safe_file.hpp"
#include "io/state_writer.hpp"
#include "io/step_log.hpp"

#include <fmt/format.h>

#include <cmath>

namespace elastogen {
namespace {

/// What a run writes beside its frames.
struct Outputs {
  std::unique_ptr<StepLog> log;
  std::unique_ptr<StateWriter> state;
};

std::unique_ptr<StateWriter> open_state(const Scene& scene, const AnimateOptions& o,
                                        const Stepper& stepper, const State& state) {
  if (o.state.empty()) return nullptr;
  StateHeader header;
  header.fps = o.fps;
  header.commit = build_commit();
  stepper.describe(header);
  return std::make_unique<StateWriter>(o.state, scene, header, state);
}

/// Steps the clip and collects what the report says of it.
class Clip {
 public:
  Clip(const Asset& asset, const AnimateOptions& options, const RunHooks& hooks, Setup& setup,
       RunResult& result)
      : o_(options),
        hooks_(hooks),
        setup_(setup),
        result_(result),
        report_(result.report),
        frames_(asset, setup, options, hooks, result.report.notes) {
    const Stopwatch watch;
    stepper_ = make_stepper(
        setup, options, [this] { return stopped(); }, report_.notes);
    report_.device = stepper_->device();
    if (report_.device != "cpu") report_.notes.push_back("iterations run on " + report_.device);
    StateHeader header;
    stepper_->describe(header);
    for (const StateNet& net : header.nets) report_.nets.push_back(net.hash);
    if (!options.quiet)
      for (const std::string& note : report_.notes) fmt::print("{}\n", note);
    state_ = stepper_->start(options.motion);
    stepper_->begin(state_);
    frames_.begin(*stepper_);
    report_.stage_seconds.setup += watch.seconds();
    if (!o_.log.empty()) outputs_.log = std::make_unique<StepLog>(o_.log);
    outputs_.state = open_state(setup.scene, options, *stepper_, state_);
  }

  void run() {
    Progress progress(o_.frames, o_.quiet);
    watch_ = Stopwatch();
    add_frame({.converged = true});
    for (int64_t frame = 1; frame <= o_.frames; ++frame) {
      FrameCertificate certificate{.converged = true, .residual = 0, .min_j = 1e300};
      if (!step_frame(frame, certificate)) break;
      add_frame(certificate);
      ++report_.frames;
      progress.update(frame, certificate.residual, certificate.converged);
    }
    const Stopwatch last;
    frames_.wait();
    report_.stage_seconds.write += last.seconds();
    report_.stage_seconds.steps = watch_.seconds() - report_.stage_seconds.write;
  }

  void finish() {
    const Stopwatch watch;
    const size_t noted = report_.notes.size();
    frames_.finish(report_);
    for (size_t n = noted; n < report_.notes.size() && !o_.quiet; ++n)
      fmt::print("{}\n", report_.notes[n]);
    if (outputs_.state) outputs_.state->finish();
    report_.stage_seconds.write += watch.seconds();
    report_.converged_share = report_.steps > 0 ? double(converged_) / double(report_.steps) : 1;
    if (converged_ < report_.steps) raise(kExitDraft);
    if (report_.min_j <= 0) {
      report_.warnings.push_back(fmt::format("a voxel is inverted: min J = {:.3g}", report_.min_j));
      raise(kExitDraft);
    }
    if (report_.outside_fit > 0)
      (o_.energy == EnergySource::kNeural ? report_.warnings : report_.notes)
          .push_back(fmt::format("in {} of {} steps voxels were strained beyond what their nets "
                                 "were fitted to, {} a step "
                                 "on average; the law gave their stress",
                                 steps_outside_, report_.steps,
                                 (report_.outside_fit + steps_outside_ - 1) / steps_outside_));
    find_long_steps();
    std::string still = said_of_stillness(setup_, o_, frames_.largest_motion());
    if (!still.empty() && report_.frames > 0 && converged_ == report_.steps)
      report_.warnings.push_back(std::move(still));
  }

 private:
  void raise(ExitCode code) {
    if (result_.code == kExitDone) result_.code = code;
  }

  /// Steps of more than 20 times the iterations of the median one, which counts as 50 at least.
  void find_long_steps() {
    constexpr double kLong = 20, kUsual = 50;
    const double median = quantile(work_, 0.5), most = kLong * std::max(median, kUsual);
    for (size_t k = 0; k < work_.size(); ++k)
      if (work_[k] > most) report_.long_steps.push_back(int64_t(k) + 1);
    if (report_.long_steps.empty()) return;
    const int64_t first = report_.long_steps[0];
    report_.notes.push_back(fmt::format(
        "long steps: {} of {}, the first is step {} with {} "
        "iterations, the median step takes {}",
        report_.long_steps.size(), work_.size(), first, work_[size_t(first - 1)], median));
    if (!o_.quiet) fmt::print("{}\n", report_.notes.back());
  }

  /// A signal came, or --max-time is over.
  bool stopped() const {
    return pending_signal() != 0 || (o_.max_time > 0 && watch_.seconds() > o_.max_time);
  }

  void say_why() {
    const int signal = pending_signal();
    if (signal != 0) {
      result_.code = ExitCode(128 + signal);
      report_.warnings.push_back("interrupted");
      return;
    }
    raise(kExitDraft);
    report_.warnings.push_back(
        fmt::format("--max-time reached after {} of {} frames", report_.frames, o_.frames));
  }

  /// False: the clip ends here, and the code says why.
  bool step_frame(int64_t frame, FrameCertificate& certificate) {
    for (int k = 0; k < setup_.substeps; ++k) {
      StepReport r;
      r.interrupted = stopped();
      if (!r.interrupted) r = stepper_->advance(state_);
      if (r.interrupted) {
        say_why();
        return false;
      }
      if (r.finite) read_state(k + 1 == setup_.substeps);
      if (!r.finite || !stepper_->fits_single(state_)) {
        result_.code = kExitDiverged;
        report_.warnings.push_back(fmt::format("frame {}: step {}: {}; the clip ends before it",
                                               frame, r.step,
                                               r.finite ? "it goes beyond single precision"
                                               : r.refusal.empty() ? "it has no finite result"
                                                                   : r.refusal));
        return false;
      }
      take(frame, r, certificate);
    }
    return true;
  }

  /// Of every step for a state file, of the last one of a frame with velocities.
  void read_state(bool frame_ends) {
    if (outputs_.state || (frame_ends && frames_.with_motion())) stepper_->read(state_);
  }

  void take(int64_t frame, const StepReport& r, FrameCertificate& certificate) {
    certificate.converged &= r.converged;
    certificate.residual = std::max(certificate.residual, r.residual);
    certificate.min_j = std::min(certificate.min_j, r.min_j);
    ++report_.steps;
    converged_ += r.converged;
    report_.worst_residual = std::max(report_.worst_residual, r.residual);
    report_.min_j = std::min(report_.min_j, r.min_j);
    report_.outside_fit += r.outside_fit;
    steps_outside_ += r.outside_fit > 0;
    report_.step_ms.push_back(r.ms);
    work_.push_back(r.inner);
    if (!r.converged && !r.refusal.empty()) report_.warnings.push_back(r.refusal);
    if (outputs_.log) outputs_.log->write(frame, r);
    if (outputs_.state) outputs_.state->step(state_, r);
    if (hooks_.on_step) hooks_.on_step(r);
  }

  /// The time that is lost to frames beside the steps.
  void add_frame(const FrameCertificate& certificate) {
    const Stopwatch watch;
    frames_.add(state_, certificate);
    report_.stage_seconds.write += watch.seconds();
  }

  const AnimateOptions& o_;
  const RunHooks& hooks_;
  Setup& setup_;
  RunResult& result_;
  RunReport& report_;
  Outputs outputs_;
  std::unique_ptr<Stepper> stepper_;
  ClipFrames frames_;
  State state_;
  int64_t converged_ = 0;
  int64_t steps_outside_ = 0;  // in which voxels lay outside the box of their nets
  std::vector<double> work_;   // inner iterations of the steps
  Stopwatch watch_;            ///< of the steps
};

void print_summary(const RunResult& result) {
  const RunReport& r = result.report;
  fmt::print("{} of {} steps converged, worst residual {:.2e}, min J {:.3f}\n",
             std::llround(r.converged_share * double(r.steps)), r.steps, r.worst_residual, r.min_j);
  fmt::print("{:.1f} ms a step (median), {:.2f} s in all\n", quantile(r.step_ms, 0.5),
             r.stage_seconds.read + r.stage_seconds.voxelize + r.stage_seconds.setup +
                 r.stage_seconds.steps + r.stage_seconds.write);
}

void warn(const std::vector<std::string>& warnings, const RunHooks& hooks) {
  for (const std::string& w : warnings)
    if (hooks.on_warning)
      hooks.on_warning(w);
    else
      fmt::print(stderr, "warning: {}\n", w);
}

/// Says what was found before the first step. @throws Error (usage) with --strict on a warning.
void say_findings(const RunReport& report, const AnimateOptions& options, const RunHooks& hooks) {
  const std::vector<Finding>& findings = report.asset.findings;
  if (!options.quiet)
    for (const std::string& line : finding_lines(findings, Severity::kNote))
      fmt::print("note: {}\n", line);
  std::vector<std::string> warnings = finding_lines(findings, Severity::kWarning);
  warnings.insert(warnings.end(), report.warnings.begin(), report.warnings.end());
  warn(warnings, hooks);
  ELASTOGEN_CHECK(!options.strict || warnings.empty(), "--strict: ", warnings[0]);
}

}  // namespace

RunResult run_animation(const Asset& asset, const AnimateOptions& options, double read_seconds,
                        const RunHooks& hooks) {
  std::optional<ThreadLimit> threads;
  if (options.threads > 0) threads.emplace(options.threads);
  RunResult result;
  RunReport& report = result.report;
  report.command = options.command;
  report.commit = build_commit();
  report.stage_seconds.read = read_seconds;

  Setup setup = hooks.set_up ? hooks.set_up(report)
                             : set_up(asset, options, hooks.materials, hooks.regions, report);
  if (options.fem && options.fem->statics)
    for (std::string& text : unheld_pieces(fem_scene(setup, options)))
      report.warnings.push_back(std::move(text));
  for (Finding& finding : output_findings(asset, setup.body.surface, options.outputs))
    report.asset.findings.push_back(std::move(finding));
  if (!options.quiet) print_setup(setup, report.asset, options);
  say_findings(report, options, hooks);
  const size_t warned = report.warnings.size();

  if (!options.report.empty()) SafeFile probe(options.report);  // refuses a folder at once
  Clip clip(asset, options, hooks, setup, result);
  clip.run();
  clip.finish();
  report.peak_memory_bytes = peak_memory_bytes();
  if (!options.report.empty()) write_report(options.report, report);
  warn({report.warnings.begin() + int64_t(warned), report.warnings.end()}, hooks);
  if (options.strict && report.warnings.size() > warned && result.code == kExitDone)
    result.code = kExitUsage;
  if (!options.quiet) print_summary(result);
  return result;
}

}  // namespace elastogen
