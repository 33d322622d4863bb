// SPDX-License-Identifier: Apache-2.0
// voxelize/embedding_impl.hpp, and a stream of its own copies them to the host while the next step
// runs.

#pragma once

#include "core/cuda/array.cuh"
#include "network/solver.hpp"
#include "voxelize/embedding.hpp"

#include <memory>

namespace elastogen::cuda {

/// A stream that waits for no other one.
class CopyStream {
 public:
  CopyStream() { check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking)); }
  CopyStream(const CopyStream&) = delete;
  ~CopyStream() { cudaStreamDestroy(stream_); }
  operator cudaStream_t() const { return stream_; }

 private:
  cudaStream_t stream_ = nullptr;
};

/// A CUDA event; a thread that waits for it sleeps.
class Event {
 public:
  Event() {
    check(cudaEventCreateWithFlags(&event_, cudaEventDisableTiming | cudaEventBlockingSync));
  }
  Event(const Event&) = delete;
  ~Event() { cudaEventDestroy(event_); }
  operator cudaEvent_t() const { return event_; }

 private:
  cudaEvent_t event_ = nullptr;
};

class DeviceFrames {
 public:
  /// Uploads the table.
  /// @throws Error (resources) if card or host have too little memory.
  DeviceFrames(const VoxelGrid& grid, const Embedding& embedding, bool with_gradient);
  /// Waits for frames that are being copied.
  ~DeviceFrames();

  /// Makes a frame after all that this thread has launched, and starts its copy to the host.
  /// @param slot     0 or 1; the frame in it is overwritten.
  /// @param x, rest  on the device [m], (nodes, 3).
  void start(int slot, const double* x, const double* rest);
  /// Waits for the frame; from any thread.
  CarriedFrame take(int slot) const;

 private:
  /// Displacements of the points, then their gradients.
  struct Slot {
    explicit Slot(int64_t size) : made(size), copied(size) {}
    DeviceArray<double> made;
    PinnedArray<double> copied;
    Event there;
  };

  double h_;
  bool with_gradient_;
  int64_t points_;
  DeviceArray<int32_t> nodes_;   // of the corners of each point's voxel, (points, 8)
  DeviceArray<double> weights_;  // (points, 8)
  Slot slots_[2];
  Event made_;
  CopyStream copies_;
};

/// Null if memory does not suffice for them and the `later_bytes` that steps will allocate.
std::unique_ptr<DeviceFrames> make_frames(const VoxelGrid& grid, const Embedding& embedding,
                                          bool with_gradient, size_t later_bytes);

}  // namespace elastogen::cuda
