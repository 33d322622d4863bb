// SPDX-License-Identifier: Apache-2.0
// Compiled without contraction (network/CMakeLists.txt), so that frames equal those of the CPU bit
// by bit.
#include "network/step/frames.cuh"
#include "network/step/memory_budget.cuh"
#include "voxelize/embedding_impl.hpp"

namespace elastogen::cuda {
namespace {

std::vector<int32_t> corner_nodes(const VoxelGrid& grid, const Embedding& embedding) {
  std::vector<int32_t> nodes(8 * size_t(embedding.voxel.rows()));
  for (int64_t p = 0; p < embedding.voxel.rows(); ++p)
    std::copy_n(grid.corners.row(embedding.voxel(p)), 8, nodes.data() + 8 * p);
  return nodes;
}

}  // namespace

DeviceFrames::DeviceFrames(const VoxelGrid& grid, const Embedding& embedding, bool with_gradient)
    : h_(grid.h),
      with_gradient_(with_gradient),
      points_(embedding.voxel.rows()),
      nodes_(corner_nodes(grid, embedding)),
      weights_(embedding.weights.size()),
      slots_{Slot((with_gradient ? 12 : 3) * points_), Slot((with_gradient ? 12 : 3) * points_)} {
  weights_.upload(embedding.weights.data());
}

DeviceFrames::~DeviceFrames() {
  cudaStreamSynchronize(copies_);
}

void DeviceFrames::start(int slot, const double* x, const double* rest) {
  Slot& to = slots_[slot];
  const int32_t* nodes = nodes_.data();
  const double *weights = weights_.data(), h = h_;
  double* displacement = to.made.data();
  double* gradient = with_gradient_ ? displacement + 3 * points_ : nullptr;
  cuda::for_each(points_, [=] __device__(int64_t p) {
    const int32_t* corners = nodes + 8 * p;
    embedded_displacement(corners, weights + 8 * p, x, rest, displacement + 3 * p);
    if (gradient) embedded_gradient(corners, weights + 8 * p, x, rest, h, gradient + 9 * p);
  });
  check(cudaEventRecord(made_, cudaStreamPerThread));
  check(cudaStreamWaitEvent(copies_, made_));
  check(cudaMemcpyAsync(to.copied.data(), to.made.data(), size_t(to.made.size()) * sizeof(double),
                        cudaMemcpyDeviceToHost, copies_));
  check(cudaEventRecord(to.there, copies_));
}

CarriedFrame DeviceFrames::take(int slot) const {
  const Slot& from = slots_[slot];
  check(cudaEventSynchronize(from.there));
  const double* displacement = from.copied.data();
  return {displacement, with_gradient_ ? displacement + 3 * points_ : nullptr};
}

std::unique_ptr<DeviceFrames> make_frames(const VoxelGrid& grid, const Embedding& embedding,
                                          bool with_gradient, size_t later_bytes) {
  try {
    auto frames = std::make_unique<DeviceFrames>(grid, embedding, with_gradient);
    if (later_bytes <= free_bytes()) return frames;
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kResources) throw;
  }
  return nullptr;
}

}  // namespace elastogen::cuda
