// SPDX-License-Identifier: Apache-2.0
#include "scene/clip_frames.hpp"

#include "scene/fem_boundary.hpp"
#include "scene/particle_setup.hpp"
#include "scene/particle_surface_writer.hpp"
#include "scene/version.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace elastogen {
namespace {

std::unique_ptr<AnimationWriter> open_animation(const std::string& path, const Asset& asset,
                                                const Setup& setup, const RunDescription& run) {
  AnimationOptions options;
  options.fps = run.fps;
  options.keyframe = run.keyframe;
  options.max_targets = run.glb_targets;
  options.colliders = run.glb_colliders;
  options.generator = version_text();
  options.command = run.command;
  options.commit = build_commit();
  options.root = root_matrix(setup.body.surface.scale, setup.up);
  options.scene = &setup.scene;
  if (setup.tets && !fem::is_plane(setup.tets->element)) options.tets = &setup.tets->elements;
  if (setup.particles) {
    options.particles = particle_set(*setup.particles);
    if (auto writer = make_particle_surface_writer(path, asset, setup)) return writer;
  }
  return AnimationWriter::create(path, asset, setup.body.surface, options);
}

}  // namespace

ClipFrames::ClipFrames(const Asset& asset, const Setup& setup, const RunDescription& run,
                       const ClipHooks& hooks, const std::function<void(std::string)>& note)
    : setup_(setup), run_(run), hooks_(hooks) {
  if (setup.particles)
    for (const std::string& text : setup.particles->notes) note(text);
  for (const std::string& path : run.outputs) {
    std::unique_ptr<AnimationWriter> writer;
    if (hooks.open_writer) writer = hooks.open_writer(path, asset, setup, note);
    animations_.push_back(writer ? std::move(writer) : open_animation(path, asset, setup, run));
  }
  for (const auto& animation : animations_) {
    with_gradient_ |= animation->needs_gradient();
    with_motion_ |= animation->needs_motion();
  }
  points_ = carried_points(setup);
}

void ClipFrames::begin(Stepper& stepper) {
  stepper_ = &stepper;
  stepper.carry(points_, with_gradient_);
}

void ClipFrames::add(const FrameCertificate& certificate) {
  const int64_t number = stepper_->start_frame();
  wait();
  AnimationFrame frame;
  frame.certificate = certificate;
  if (with_motion_) {
    frame.state = &grid_state();
    frame.particles = stepper_->particles();
    if (!frame.particles) frame.residual = {stepper_->residual().data, frame.state->x.rows(), 3};
    return write(number, frame);
  }
  // with one thread the frame is written there, when it is waited for
  const auto policy = run_.threads == 1 ? std::launch::deferred : std::launch::async;
  writing_ = std::async(policy, [this, number, frame] { write(number, frame); });
}

void ClipFrames::wait() {
  if (writing_.valid()) writing_.get();
}

std::vector<std::string> ClipFrames::finish(const std::function<void(std::string)>& note) {
  std::vector<std::string> warnings;
  for (const auto& animation : animations_) {
    animation->finish();
    for (const std::string& text : animation->notes()) note(text);
    for (const std::string& text : animation->warnings()) warnings.push_back(text);
  }
  return warnings;
}

/// The state of the grid's nodes alone; quadratic elements have more nodes.
const State& ClipFrames::grid_state() {
  const State& state = stepper_->state();
  const int64_t nodes = setup_.scene.grid.node_count();
  if (setup_.particles || state.x.rows() == nodes) return state;
  grid_state_.x = grid_state_.v = Array<double>(nodes, 3);
  std::copy_n(state.x.data(), 3 * nodes, grid_state_.x.data());
  std::copy_n(state.v.data(), 3 * nodes, grid_state_.v.data());
  grid_state_.time = state.time;
  return grid_state_;
}

/// Time of a frame on the paths of holders; in statics the load factor is the share of the way [s].
double ClipFrames::path_time(int64_t number) const {
  const bool is_static = run_.fem && run_.fem->statics && number > 0;
  return is_static ? end_of_moves(run_) * stepper_->state().time : double(number) / run_.fps;
}

/// A frame whose points go with holders that move.
CarriedFrame ClipFrames::with_moved(const CarriedFrame& carried, double time) {
  displacement_ = Array<double>(points_.count, 3);
  std::copy_n(carried.displacement, displacement_.size(), displacement_.data());
  if (with_gradient_) {
    gradient_ = Array<double>(points_.count, 9);
    std::copy_n(carried.gradient, gradient_.size(), gradient_.data());
  }
  place_moved(points_, setup_, time, displacement_, with_gradient_ ? &gradient_ : nullptr);
  return {displacement_.data(), with_gradient_ ? gradient_.data() : nullptr};
}

void ClipFrames::write(int64_t number, AnimationFrame frame) {
  const int64_t points = points_.count;
  CarriedFrame carried = stepper_->take_frame(number);
  if (!points_.moved.empty()) carried = with_moved(carried, path_time(number));
  frame.displacement = {carried.displacement, points, 3};
  if (with_gradient_) frame.gradient = {carried.gradient, points, 9};
  for (int64_t k = 0; k < 3 * points; ++k)
    largest_motion_ = std::max(largest_motion_, std::abs(carried.displacement[k]));
  for (const auto& animation : animations_) animation->frame(frame);
  if (!hooks_.on_frame) return;
  Array<double> positions = setup_.body.carried;
  for (int64_t k = 0; k < positions.size(); ++k)
    positions.data()[k] += setup_.scene.place[size_t(k % 3)] + carried.displacement[k];
  hooks_.on_frame(positions);
}

}  // namespace elastogen
