// SPDX-License-Identifier: Apache-2.0
// A second stream of launches beside that of the thread, for work that the card can do at the same
// time. Graphs record both.

#pragma once

#include "core/cuda/pinned.cuh"

namespace elastogen::cuda {

class DeviceBranch {
 public:
  DeviceBranch() = default;
  DeviceBranch(const DeviceBranch&) = delete;
  ~DeviceBranch() {
    if (!stream_) return;
    for (cudaEvent_t event : {begun_, ended_}) cudaEventDestroy(event);
    cudaStreamDestroy(stream_);
  }

  /// Calls body(stream); its launches there begin after all launches of the thread so far.
  template <class Body>
  void begin(const Body& body) {
    if (!stream_) open();
    check(cudaEventRecord(begun_, cudaStreamPerThread));
    check(cudaStreamWaitEvent(stream_, begun_));
    body(stream_);
    check(cudaEventRecord(ended_, stream_));
  }

  /// Later launches of the thread begin after those of body(); the first of them must not be early.
  void end() { check(cudaStreamWaitEvent(cudaStreamPerThread, ended_)); }

 private:
  void open() {
    check(cudaStreamCreateWithFlags(&stream_, cudaStreamNonBlocking));
    for (cudaEvent_t* event : {&begun_, &ended_})
      check(cudaEventCreateWithFlags(event, cudaEventDisableTiming));
  }

  cudaStream_t stream_ = nullptr;
  cudaEvent_t begun_ = nullptr, ended_ = nullptr;
};

}  // namespace elastogen::cuda
