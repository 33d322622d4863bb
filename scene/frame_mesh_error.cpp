// SPDX-License-Identifier: Apache-2.0
#include "scene/frame_mesh_error.hpp"

#include "scene/fem_scene.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr int64_t kFramesOnCard = 8;

bool has_elastic_voxels(const Setup& setup, const RunDescription& run) {
  if (setup.particles || setup.tets || !setup.yields.empty()) return false;
  if (run.fem) return run.fem->element == fem::Element::kVoxel;
  return run.solver.mode != SolverMode::kPaper;
}

bool is_static(const RunDescription& run) {
  return run.fem && run.fem->statics;
}

}  // namespace

FrameMeshError::FrameMeshError(const Setup& setup, const RunDescription& run,
                               const CarriedPoints& points)
    : setup_(setup), run_(run), points_(points) {}

void FrameMeshError::begin(Stepper& stepper) {
  if (!run_.mesh_error || run_.frames == 0 || !has_elastic_voxels(setup_, run_)) return;
  if (stepper.device() != "cpu") stride_ = std::min(kFramesOnCard, run_.frames);
  const double interval = is_static(run_) ? 0 : double(stride_) / run_.fps;
  if (run_.fem)
    number_ = std::make_unique<MeshNumber>(setup_.scene, interval, fem_scene(setup_, run_).fixed);
  else
    number_ = std::make_unique<MeshNumber>(setup_.scene, interval);
  number_->begin(positions(stepper));
}

std::optional<MeshError> FrameMeshError::of_frame(Stepper& stepper, int64_t frame) {
  if (!number_ || (frame % stride_ != 0 && frame != run_.frames)) return {};
  const double interval = double(frame - last_) / run_.fps;
  last_ = frame;
  return number_->estimate(positions(stepper), interval, points_.embedding);
}

In<double> FrameMeshError::positions(Stepper& stepper) const {
  return {stepper.state().x.data(), setup_.scene.grid.node_count(), 3};
}

void add_frame(const MeshError& frame, RunMeshError& run) {
  ++run.frames;
  run.untrusted += !frame.trusted;
  run.rms = std::max(run.rms, frame.rms);
  run.largest = std::max(run.largest, frame.largest);
}

}  // namespace elastogen
