// SPDX-License-Identifier: Apache-2.0
#include "scene/clip.hpp"

#include "core/step_verdict.hpp"
#include "core/stopwatch.hpp"
#include "io/state_writer.hpp"
#include "io/step_log.hpp"
#include "scene/clip_frames.hpp"
#include "scene/frame_mesh_error.hpp"
#include "scene/moved_points.hpp"
#include "scene/stepper.hpp"
#include "scene/still.hpp"
#include "scene/version.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace elastogen {
namespace {

/// Steps the clip and collects results for the report.
class Clip {
 public:
  Clip(const Asset& asset, const Setup& setup, const RunDescription& run, const ClipHooks& hooks,
       RunReport& report)
      : setup_(setup),
        run_(run),
        hooks_(hooks),
        report_(report),
        note_([this](std::string text) { note(std::move(text)); }),
        frames_(asset, setup, run, hooks, note_),
        mesh_(setup, run, frames_.points()) {
    const Stopwatch watch;
    make_stepper();
    stepper_->begin(run.motion);
    frames_.begin(*stepper_);
    mesh_.begin(*stepper_);
    report_.stage_seconds.setup += watch.seconds();
    if (!run.log.empty()) log_ = std::make_unique<StepLog>(run.log);
    if (!run.state.empty()) open_state();
  }

  /// Makes all steps of the clip.
  void play() {
    watch_ = Stopwatch();
    add_frame({.converged = true});
    for (int64_t frame = 1; frame <= run_.frames; ++frame) {
      FrameCertificate certificate{.converged = true, .residual = 0, .min_j = 1e300};
      if (!step_frame(frame, certificate)) break;
      add_frame(certificate);
      ++report_.frames;
      if (hooks_.on_progress) hooks_.on_progress(frame, certificate);
    }
    const Stopwatch last;
    frames_.wait();
    report_.mesh_error.largest_motion = frames_.largest_motion();
    report_.stage_seconds.write += last.seconds();
    report_.stage_seconds.steps = watch_.seconds() - report_.stage_seconds.write;
  }

  /// Completes the files and judges the clip.
  ClipEnd finish() {
    const Stopwatch watch;
    for (std::string& text : frames_.finish(note_)) report_.warnings.push_back(std::move(text));
    if (state_file_) finish_state();
    report_.stage_seconds.write += watch.seconds();
    report_.converged_share = report_.steps > 0 ? double(converged_) / double(report_.steps) : 1;
    report_.solved_share = report_.steps > 0 ? double(solved_) / double(report_.steps) : 1;
    if (solved_ < report_.steps) raise(ClipEnd::kDraft);
    if (!why_draft_.empty()) report_.warnings.push_back(why_draft_);
    if (report_.min_j <= 0) {
      report_.warnings.push_back(fmt::format("a voxel is inverted: min J = {:.3g}", report_.min_j));
      raise(ClipEnd::kDraft);
    }
    judge_fits();
    find_long_steps();
    std::string still = said_of_stillness(setup_, run_, frames_.largest_motion());
    if (!still.empty() && report_.frames > 0 && solved_ == report_.steps)
      report_.warnings.push_back(std::move(still));
    return end_;
  }

 private:
  void note(std::string text) {
    if (hooks_.on_note) hooks_.on_note(text);
    report_.notes.push_back(std::move(text));
  }

  void raise(ClipEnd end) {
    if (end_ == ClipEnd::kConverged) end_ = end;
  }

  void make_stepper() {
    std::vector<std::string> notes;
    stepper_ = elastogen::make_stepper(setup_, run_,
                                       {[this] { return stopped(); }, hooks_.make_net}, notes);
    for (std::string& text : notes) note(std::move(text));
    report_.device = stepper_->device();
    if (report_.device != "cpu") note("iterations run on " + report_.device);
    StateHeader header;
    stepper_->describe(header);
    for (const StateNet& net : header.nets) report_.nets.push_back(net.hash);
  }

  void open_state() {
    StateHeader header;
    header.fps = run_.fps;
    header.commit = build_commit();
    stepper_->describe(header);
    state_file_ = std::make_unique<StateWriter>(run_.state, setup_.scene, header, stepper_->state(),
                                                stepper_->particles());
  }

  void finish_state() {
    if (std::optional<StatePlastic> plastic = stepper_->plastic())
      state_file_->set_plastic(std::move(*plastic));
    state_file_->finish();
  }

  /// Whether a stop was requested or the time is up.
  bool stopped() const {
    return asked_to_stop() || (run_.max_time > 0 && watch_.seconds() > run_.max_time);
  }
  bool asked_to_stop() const { return hooks_.stop && hooks_.stop(); }

  void say_why() {
    if (asked_to_stop()) {
      end_ = ClipEnd::kStopped;
      report_.warnings.push_back("interrupted");
      return;
    }
    raise(ClipEnd::kDraft);
    report_.warnings.push_back(
        fmt::format("--max-time reached after {} of {} frames", report_.frames, run_.frames));
  }

  /// A step, refused where what goes along with a move runs into a collider.
  StepReport advance() {
    StepReport r = stepper_->advance();
    if (r.interrupted || !r.finite || (run_.fem && run_.fem->statics)) return r;
    const std::string refusal = collider_in_the_way(setup_, r.time);
    if (!refusal.empty()) r.finite = false, r.refusal = refusal;
    return r;
  }

  /// @return false if the clip ends here; end_ and a warning then say why.
  bool step_frame(int64_t frame, FrameCertificate& certificate) {
    // steps, until they make up the frame
    for (int k = 0; k < setup_.substeps;) {
      // a step, unless the clip ends here
      StepReport r;
      r.interrupted = stopped();
      if (!r.interrupted) r = advance();
      if (r.interrupted) {
        say_why();
        return false;
      }
      if (!r.finite || !stepper_->fits_single()) {
        end_ = ClipEnd::kDiverged;
        report_.warnings.push_back(fmt::format("frame {}: step {}: {}; the clip ends before it",
                                               frame, r.step,
                                               r.finite ? "it goes beyond single precision"
                                               : r.refusal.empty() ? "it has no finite result"
                                                                   : r.refusal));
        return false;
      }
      k += r.completes;
      if (k == setup_.substeps) r.mesh_error = mesh_.of_frame(*stepper_, frame);
      take(frame, r, certificate);
    }
    report_.largest_time_error = std::max(report_.largest_time_error, certificate.time_error);
    report_.frames_over += certificate.time_ratio > 1;
    return true;
  }

  void take(int64_t frame, const StepReport& r, FrameCertificate& certificate) {
    // the frame, then the run
    certificate.converged &= is_converged(r);
    certificate.residual = std::max(certificate.residual, r.residual);
    certificate.min_j = std::min(certificate.min_j, r.min_j);
    certificate.time_error += r.time_error;
    certificate.time_ratio = std::max(certificate.time_ratio, r.time_ratio);
    if (r.mesh_error) {
      certificate.mesh_error = r.mesh_error;
      elastogen::add_frame(*r.mesh_error, report_.mesh_error);
    }
    report_.ledger.add(r.ledger);
    report_.reactions = r.reactions;
    report_.time_error += r.time_error;
    report_.loosest_tolerance = std::max(report_.loosest_tolerance, r.tolerance);
    report_.damped += r.damped;
    report_.solves += r.solves;
    report_.rejected_steps += r.rejected;
    ++report_.steps;
    converged_ += is_converged(r);
    solved_ += r.converged;
    report_.worst_residual = std::max(report_.worst_residual, r.residual);
    report_.min_j = std::min(report_.min_j, r.min_j);
    report_.outside_fit += r.outside_fit;
    steps_outside_ += r.outside_fit > 0;
    report_.step_ms.push_back(r.ms);
    work_.push_back(r.inner);
    if (!r.converged && !r.refusal.empty()) note_draft(r);
    // files
    if (log_) log_->write(frame, r, stepper_->cloud());
    if (state_file_) keep_state(r);
    if (hooks_.on_step) hooks_.on_step(r);
  }

  /// Of all drafts the one that missed its tolerance by most is told of.
  void note_draft(const StepReport& r) {
    const double missed = r.residual / std::max(r.tolerance, 1e-300);
    if (missed <= worst_draft_) return;
    worst_draft_ = missed;
    why_draft_ = r.refusal;
  }

  void keep_state(const StepReport& r) {
    const State& state = stepper_->state();
    state_file_->step(state, r, stepper_->particles(), stepper_->stage_data());
  }

  /// Adds a frame, and its time that steps had to wait to the report.
  void add_frame(const FrameCertificate& certificate) {
    const Stopwatch watch;
    frames_.add(certificate);
    report_.stage_seconds.write += watch.seconds();
  }

  /// Notes where laws replaced nets; a warning if nets were requested.
  void judge_fits() {
    if (report_.outside_fit == 0) return;
    const bool asked = run_.energy == EnergySource::kNeural;
    (asked ? report_.warnings : report_.notes)
        .push_back(fmt::format("in {} of {} steps voxels were strained beyond what their nets "
                               "were fitted to, {} a step "
                               "on average; the law gave their stress",
                               steps_outside_, report_.steps,
                               (report_.outside_fit + steps_outside_ - 1) / steps_outside_));
  }

  /// Finds steps with more than 20 times the iterations of the median step, counted as at least 50.
  void find_long_steps() {
    constexpr double kLong = 20, kUsual = 50;
    const double median = quantile(work_, 0.5), most = kLong * std::max(median, kUsual);
    for (size_t k = 0; k < work_.size(); ++k)
      if (work_[k] > most) report_.long_steps.push_back(int64_t(k) + 1);
    if (report_.long_steps.empty()) return;
    const int64_t first = report_.long_steps[0];
    note(fmt::format(
        "long steps: {} of {}, the first is step {} with {} "
        "iterations, the median step takes {}",
        report_.long_steps.size(), work_.size(), first, work_[size_t(first - 1)], median));
  }

  const Setup& setup_;
  const RunDescription& run_;
  const ClipHooks& hooks_;
  RunReport& report_;
  ClipEnd end_ = ClipEnd::kConverged;
  std::function<void(std::string)> note_;
  std::unique_ptr<StepLog> log_;
  std::unique_ptr<StateWriter> state_file_;
  std::unique_ptr<Stepper> stepper_;
  ClipFrames frames_;
  FrameMeshError mesh_;
  int64_t converged_ = 0;    ///< steps
  int64_t solved_ = 0;       ///< steps whose residual is as asked for, whatever their time error
  double worst_draft_ = -1;  ///< residual over its tolerance, and what is to be said of it
  std::string why_draft_;
  int64_t steps_outside_ = 0;  ///< steps in which voxels were outside the box of their nets
  std::vector<double> work_;   ///< inner iterations of the steps
  Stopwatch watch_;            ///< of the steps
};

}  // namespace

ClipEnd play_clip(const Asset& asset, const Setup& setup, const RunDescription& run,
                  const ClipHooks& hooks, RunReport& report) {
  Clip clip(asset, setup, run, hooks, report);
  clip.play();
  return clip.finish();
}

}  // namespace elastogen
