// SPDX-License-Identifier: Apache-2.0
// Launches that are recorded once and then repeated as one, which costs the host and the card a
// fraction of the single launches of many short kernels. Needs --default-stream=per-thread, as the
// legacy default stream cannot be recorded.

#pragma once

#include "core/cuda/array.cuh"

namespace elastogen::cuda {

class DeviceGraph {
 public:
  DeviceGraph() = default;
  DeviceGraph(const DeviceGraph&) = delete;
  ~DeviceGraph() {
    if (graph_) cudaGraphExecDestroy(graph_);
  }

  /// Does what the launches of body() do. body must make the same launches on the same memory every
  /// time and neither allocate nor wait. Its first run is direct, the second is recorded. While
  /// another graph is recorded they become a part of that one.
  template <class Body>
  void run(const Body& body) {
    if (is_recording()) return body();
    if (!warm_) {
      warm_ = true;
      return body();
    }
    if (!graph_) record(body);
    check(cudaGraphLaunch(graph_, cudaStreamPerThread));
  }
  /// The launches are others from now on: the next run is direct again.
  void forget() {
    if (graph_) check(cudaGraphExecDestroy(graph_));
    graph_ = nullptr;
    warm_ = false;
  }

 private:
  static bool is_recording() {
    cudaStreamCaptureStatus status;
    check(cudaStreamIsCapturing(cudaStreamPerThread, &status));
    return status != cudaStreamCaptureStatusNone;
  }
  template <class Body>
  void record(const Body& body) {
    const std::lock_guard lock(device_wide());
    cudaGraph_t recorded;
    check(cudaStreamBeginCapture(cudaStreamPerThread, cudaStreamCaptureModeThreadLocal));
    body();
    check(cudaStreamEndCapture(cudaStreamPerThread, &recorded));
    const cudaError_t made = cudaGraphInstantiate(&graph_, recorded, 0);
    cudaGraphDestroy(recorded);
    check(made);
  }

  bool warm_ = false;
  cudaGraphExec_t graph_ = nullptr;
};

}  // namespace elastogen::cuda
