// SPDX-License-Identifier: Apache-2.0
#include "bench/card.hpp"
#include "bench/timing.hpp"
#include "core/cuda/array.cuh"

#include <algorithm>

namespace elastogen::bench {
namespace {

using cuda::check;
using cuda::DeviceArray;

constexpr int kRepeats = 11;
constexpr int kChains = 8;     // independent multiply-adds of a thread
constexpr int kRounds = 4096;  // of each chain
constexpr int kThreads = 256;
constexpr int kLaunches = 1000;

void wait() {
  check(cudaDeviceSynchronize());
}

__global__ void nothing() {}

template <class T>
__global__ void __launch_bounds__(kThreads) multiply_add(T* out, T a, T b) {
  T x[kChains];
#pragma unroll
  for (int k = 0; k < kChains; ++k) x[k] = T(threadIdx.x + k);
  for (int r = 0; r < kRounds; ++r)
#pragma unroll
    for (int k = 0; k < kChains; ++k) x[k] = x[k] * a + b;
  T sum = 0;
#pragma unroll
  for (int k = 0; k < kChains; ++k) sum += x[k];
  out[blockIdx.x * kThreads + threadIdx.x] = sum;
}

/// Multiplications and additions a second.
template <class T>
double rate(int multiprocessors) {
  const int blocks = 32 * multiprocessors;
  DeviceArray<T> out(int64_t(blocks) * kThreads);
  const Spread ms = milliseconds(
      kRepeats,
      [&] {
        multiply_add<T><<<unsigned(blocks), kThreads>>>(out.data(), T(0.999), T(0.001));
        check(cudaGetLastError());
      },
      wait);
  return 2e3 * kChains * double(kRounds) * double(out.size()) / ms.median;
}

double launch_microseconds() {
  const Spread ms = milliseconds(
      kRepeats,
      [] {
        for (int k = 0; k < kLaunches; ++k) nothing<<<1, 32>>>();
        check(cudaGetLastError());
      },
      wait);
  return 1e3 * ms.median / kLaunches;
}

double graph_node_microseconds() {
  cudaStream_t stream;
  cudaGraph_t graph;
  cudaGraphExec_t ready;
  check(cudaStreamCreateWithFlags(&stream, cudaStreamNonBlocking));
  check(cudaStreamBeginCapture(stream, cudaStreamCaptureModeThreadLocal));
  for (int k = 0; k < kLaunches; ++k) nothing<<<1, 32, 0, stream>>>();
  check(cudaStreamEndCapture(stream, &graph));
  check(cudaGraphInstantiate(&ready, graph, 0));
  const Spread ms = milliseconds(
      kRepeats, [&] { check(cudaGraphLaunch(ready, stream)); }, wait);
  check(cudaGraphExecDestroy(ready));
  check(cudaGraphDestroy(graph));
  check(cudaStreamDestroy(stream));
  return 1e3 * ms.median / kLaunches;
}

double sync_microseconds() {
  const Spread ms = milliseconds(kRepeats, [] {
    for (int k = 0; k < kLaunches; ++k) {
      nothing<<<1, 32>>>();
      check(cudaStreamSynchronize(nullptr));
    }
  });
  return 1e3 * ms.median / kLaunches;
}

double fetch_microseconds() {
  const DeviceArray<double> few(8);
  double host[8];
  const Spread ms = milliseconds(kRepeats, [&] {
    for (int k = 0; k < kLaunches; ++k) few.download(host);
  });
  return 1e3 * ms.median / kLaunches;
}

}  // namespace

double card_copy_rate() {
  size_t free = 0, total = 0;
  check(cudaMemGetInfo(&free, &total));
  const auto bytes = int64_t(std::min(size_t(2) << 30, free / 8));
  DeviceArray<char> from(bytes), to(bytes);
  const Spread ms = milliseconds(
      kRepeats,
      [&] {
        check(cudaMemcpyAsync(to.data(), from.data(), size_t(bytes), cudaMemcpyDeviceToDevice));
      },
      wait);
  return 2e3 * double(bytes) / ms.median;
}

CardCeilings card_ceilings() {
  int device = 0;
  check(cudaGetDevice(&device));
  cudaDeviceProp properties;
  check(cudaGetDeviceProperties(&properties, device));
  CardCeilings c;
  c.multiprocessors = properties.multiProcessorCount;
  c.memory_bytes = int64_t(properties.totalGlobalMem);
  c.copy = card_copy_rate();
  c.float_rate = rate<float>(c.multiprocessors);
  c.double_rate = rate<double>(c.multiprocessors);
  c.launch_us = launch_microseconds();
  c.graph_node_us = graph_node_microseconds();
  c.sync_us = sync_microseconds();
  c.fetch_us = fetch_microseconds();
  return c;
}

int64_t card_memory_used() {
  size_t free = 0, total = 0;
  check(cudaMemGetInfo(&free, &total));
  return int64_t(total - free);
}

}  // namespace elastogen::bench
