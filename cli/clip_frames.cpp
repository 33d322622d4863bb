// SPDX-License-Identifier: Apache-2.0
#include "cli/clip_frames.hpp"

#include "cli/picture/picture_writer.hpp"
#include "cli/version.hpp"
#include "io/safe_file.hpp"
#include "voxelize/labels.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

namespace elastogen {
namespace {

std::unique_ptr<AnimationWriter> open_animation(const std::string& path, const Asset& asset,
                                                const Setup& setup, const AnimateOptions& o,
                                                std::vector<std::string>& notes) {
  if (ending_of(path) == "png")
    return make_picture_writer(path, asset, setup, o.fps, o.picture, notes);
  AnimationOptions options;
  options.fps = o.fps;
  options.keyframe = o.keyframe;
  options.max_targets = o.glb_targets;
  options.colliders = o.glb_colliders;
  options.generator = version_text();
  options.command = o.command;
  options.commit = build_commit();
  options.root = root_matrix(setup.body.surface.scale, setup.up);
  options.scene = &setup.scene;
  if (setup.tets) options.tets = &setup.tets->elements;
  return AnimationWriter::create(path, asset, setup.body.surface, options);
}

}  // namespace

ClipFrames::ClipFrames(const Asset& asset, const Setup& setup, const AnimateOptions& options,
                       const RunHooks& hooks, std::vector<std::string>& notes)
    : setup_(setup), options_(options), hooks_(hooks) {
  for (const std::string& path : options.outputs)
    animations_.push_back(open_animation(path, asset, setup, options, notes));
  for (const auto& animation : animations_) {
    with_gradient_ |= animation->needs_gradient();
    with_motion_ |= animation->needs_motion();
  }
  if (!setup.tets)
    embedding_ = embed(setup.scene.grid, setup.body.carried, parts_of_carried(setup.body));
}

void ClipFrames::begin(Stepper& stepper) {
  stepper_ = &stepper;
  by_stepper_ = !with_motion_ && !setup_.tets && stepper.carry(embedding_, with_gradient_);
  if (by_stepper_) return;
  const int64_t points = setup_.body.carried.rows();
  for (Made& made : made_) {
    made.displacement = Array<double>(points, 3);
    if (with_gradient_) made.gradient = Array<double>(points, 9);
  }
}

void ClipFrames::add(const State& state, const FrameCertificate& certificate) {
  const int64_t number = by_stepper_ ? stepper_->start_frame() : make(state);
  wait();
  AnimationFrame frame;
  frame.certificate = certificate;
  if (with_motion_) {
    frame.state = &grid_state(state);
    frame.residual = {stepper_->residual().data, frame.state->x.rows(), 3};
    return write(number, frame);
  }
  // with one thread a frame is written there, when it is waited for
  const auto policy = options_.threads == 1 ? std::launch::deferred : std::launch::async;
  writing_ = std::async(policy, [this, number, frame] { write(number, frame); });
}

void ClipFrames::wait() {
  if (writing_.valid()) writing_.get();
}

void ClipFrames::finish(RunReport& report) {
  const auto append = [](std::vector<std::string>& to, const std::vector<std::string>& texts) {
    to.insert(to.end(), texts.begin(), texts.end());
  };
  for (const auto& animation : animations_) {
    animation->finish();
    append(report.notes, animation->notes());
    append(report.warnings, animation->warnings());
  }
}

/// Makes a frame in the place of the last but one, which is written.
int64_t ClipFrames::make(const State& state) {
  Made& made = made_[count_ % 2];
  const State& of_grid = grid_state(state);
  carry(of_grid, made.displacement);
  if (with_gradient_) deformation_gradient(setup_.scene.grid, embedding_, of_grid.x, made.gradient);
  return count_++;
}

/// Moves the carried points with the grid, or as nodes of the tetrahedra.
void ClipFrames::carry(const State& state, Array<double>& displacement) const {
  if (!setup_.tets) {
    deform_asset(setup_.scene.grid, embedding_, state.x, displacement);
    return;
  }
  for (int64_t p = 0; p < displacement.rows(); ++p)
    for (int d = 0; d < 3; ++d) {
      const int32_t node = setup_.node_of(p);
      displacement(p, d) = state.x(node, d) - setup_.tets->rest(node, d);
    }
}

/// The state of the grid's nodes alone: quadratic elements have more.
const State& ClipFrames::grid_state(const State& state) {
  const int64_t nodes = setup_.scene.grid.node_count();
  if (state.x.rows() == nodes) return state;
  grid_state_.x = grid_state_.v = Array<double>(nodes, 3);
  std::copy_n(state.x.data(), 3 * nodes, grid_state_.x.data());
  std::copy_n(state.v.data(), 3 * nodes, grid_state_.v.data());
  grid_state_.time = state.time;
  return grid_state_;
}

CarriedFrame ClipFrames::made(int64_t number) const {
  if (by_stepper_) return stepper_->take_frame(number);
  const Made& made = made_[number % 2];
  return {made.displacement.data(), made.gradient.data()};
}

void ClipFrames::write(int64_t number, AnimationFrame frame) {
  const int64_t points = setup_.body.carried.rows();
  const CarriedFrame carried = made(number);
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
