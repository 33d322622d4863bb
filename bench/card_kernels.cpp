// SPDX-License-Identifier: Apache-2.0
#include "bench/card.hpp"
#include "bench/timing.hpp"
#include "core/error.hpp"
#include "network/device_quasi.hpp"

#include <cuda_runtime_api.h>

namespace elastogen::bench {
namespace {

constexpr int kRepeats = 21;

void check(cudaError_t error) {
  if (error != cudaSuccess)
    throw Error(concat("CUDA: ", cudaGetErrorString(error)), ErrorKind::kResources);
}

/// Zeros on the device.
template <class T>
struct Room {
  explicit Room(int64_t size) {
    const size_t bytes = size_t(size) * sizeof(T);
    check(cudaMalloc(reinterpret_cast<void**>(&data), bytes));
    check(cudaMemset(data, 0, bytes));
  }
  ~Room() { cudaFree(data); }
  Room(const Room&) = delete;
  T* data = nullptr;
};

}  // namespace

std::vector<KernelRow> card_kernels(const Scene& scene) {
  IncrementalPotential potential(scene);
  potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
  const Preconditioner<float> first(potential, true), cycle(potential, false);
  cuda::DeviceQuasi quasi(potential, first), without(potential, cycle);
  const auto V = double(scene.grid.voxel_count()), N = double(scene.grid.node_count());
  Room<double> u(int64_t(3 * N)), gradient(int64_t(3 * N));
  Room<float> r(int64_t(3 * N)), z(int64_t(3 * N)), single(int64_t(3 * N));
  for (cuda::DeviceQuasi* q : {&quasi, &without}) {
    q->begin_step();
    q->set_nodal_rotations(potential.now().data());
  }
  std::vector<KernelRow> rows;
  const auto row = [&](const char* name, double bytes, const std::function<void()>& body) {
    const auto wait = [] { check(cudaDeviceSynchronize()); };
    rows.push_back({name, bytes, milliseconds(kRepeats, body, wait).median});
  };
  // u, predictor, inertia, gradient; weights and rotations
  row("energy and gradient, float", N * (24 + 24 + 8 + 12) + V * 4 * 14,
      [&] { quasi.potential().evaluate<float>(u.data, single.data); });
  row("energy and gradient, double", N * (24 + 24 + 8 + 24) + V * 8 * 14,
      [&] { quasi.potential().evaluate<double>(u.data, gradient.data); });
  row("nodal rotations", N * (3 * 24 + 3 * 36) + V * 4,
      [&] { quasi.potential().set_nodal_rotations(u.data); });
  // on the finest level start, residual, two smoothings and a correction of vectors of 12 B a node
  // and 4 B of row; an eighth of all below it; turned by rotations before and after
  const double levels = 8.0 / 7 * N * (40 + 31 + 28 + 40 + 52 + 44) + N * 2 * (12 + 36 + 12);
  row("V-cycle, float", levels, [&] { without.precondition(r.data, z.data); });
  row("V-cycle and encoder, float", levels + N * 2 * (84 + 12),
      [&] { quasi.precondition(r.data, z.data); });
  return rows;
}

}  // namespace elastogen::bench
