// SPDX-License-Identifier: Apache-2.0
// Frames of a clip: on the device where steps run there and it has room, else here.
#include "core/error.hpp"
#include "network/solver_impl.hpp"
#include "voxelize/embedding.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

void Solver::Impl::make_frame(int slot) {
  State read;
  if (on_device) on_device->download(read, StateParts::kPositions);
  const Array<double>& x = on_device ? read.x : clip.x;
  deform_asset(scene.grid, *embedding, x, frame[slot].displacement);
  if (!frame[slot].gradient.empty())
    deformation_gradient(scene.grid, *embedding, x, frame[slot].gradient);
}

double Solver::reach() const {
  const Impl& s = *impl_;
  ELASTOGEN_CHECK(s.in_clip, "reach() comes after begin()");
  if (s.on_device) return s.on_device->reach();
  double largest = 0;
  for (int64_t k = 0; k < s.clip.x.size(); ++k)
    largest = std::max(largest, std::abs(s.clip.x.data()[k]));
  return largest;
}

void Solver::carry(const Embedding& embedding, bool with_gradient) {
  Impl& s = *impl_;
  const int64_t points = embedding.voxel.rows(), voxels = s.scene.grid.voxel_count();
  ELASTOGEN_CHECK(Span<const double>(embedding.weights).is(points, 8), "weights must be (", points,
                  ", 8), got ", Span<const double>(embedding.weights));
  for (int64_t p = 0; p < points; ++p)
    ELASTOGEN_CHECK(embedding.voxel(p) >= 0 && embedding.voxel(p) < voxels, "point ", p,
                    " lies in voxel ", embedding.voxel(p), " of ", voxels);
  s.embedding = &embedding;
  s.frames = 0;
  s.frames_on_device = s.on_device && s.on_device->carry(embedding, with_gradient);
  for (Impl::Frame& frame : s.frame) {
    const bool here = !s.frames_on_device;
    frame.displacement = here ? Array<double>(points, 3) : Array<double>();
    frame.gradient = here && with_gradient ? Array<double>(points, 9) : Array<double>();
  }
}

int64_t Solver::start_frame() {
  Impl& s = *impl_;
  ELASTOGEN_CHECK(s.in_clip && s.embedding, "start_frame() comes after begin() and carry()");
  const int slot = int(s.frames % 2);
  if (s.frames_on_device)
    s.on_device->start_frame(slot);
  else
    s.make_frame(slot);
  return s.frames++;
}

CarriedFrame Solver::take_frame(int64_t number) const {
  const Impl& s = *impl_;
  const int64_t frames = s.frames;
  ELASTOGEN_CHECK(number >= 0 && number < frames && number >= frames - 2, "frame ", number,
                  " is not one of the last two of ", frames);
  const int slot = int(number % 2);
  if (s.frames_on_device) return s.on_device->take_frame(slot);
  const Impl::Frame& frame = s.frame[slot];
  return {frame.displacement.data(), frame.gradient.empty() ? nullptr : frame.gradient.data()};
}

}  // namespace elastogen
