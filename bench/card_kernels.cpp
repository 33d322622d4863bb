// SPDX-License-Identifier: Apache-2.0
#include "bench/card.hpp"
#include "bench/card_tangents.hpp"
#include "bench/timing.hpp"
#include "core/error.hpp"
#include "network/step/quasi_solver_device.hpp"

#include <cuda_runtime_api.h>

#include <cmath>
#include <functional>

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

template <class T>
void upload(const std::vector<T>& host, Room<T>& room) {
  check(cudaMemcpy(room.data, host.data(), host.size() * sizeof(T), cudaMemcpyHostToDevice));
}

template <class T>
std::vector<T> download(const Room<T>& room, size_t size) {
  std::vector<T> host(size);
  check(cudaMemcpy(host.data(), room.data, size * sizeof(T), cudaMemcpyDeviceToHost));
  return host;
}

/// |a - b| / |b|
double relative_difference(const std::vector<float>& a, const std::vector<float>& b) {
  double difference = 0, size = 0;
  for (size_t k = 0; k < b.size(); ++k) {
    difference += std::pow(double(a[k]) - double(b[k]), 2);
    size += std::pow(double(b[k]), 2);
  }
  return std::sqrt(difference / size);
}

/// The rows of a scene.
struct Rows {
  void add(const char* name, double bytes, const std::function<void()>& body) {
    const auto wait = [] { check(cudaDeviceSynchronize()); };
    list.push_back({name, bytes, milliseconds(kRepeats, body, wait).median});
  }
  std::vector<KernelRow> list;
};

/// The Hessian of `newton`, whose tangents are kept, and a product that makes them anew, at a
/// strained state.
void add_hessians(const Scene& scene, cuda::DevicePotential& potential, Rows& rows) {
  const auto V = double(scene.grid.voxel_count()), N = double(scene.grid.node_count());
  const auto size = size_t(3 * scene.grid.node_count());
  std::vector<double> shaken(size);
  std::vector<float> direction(size);
  for (size_t k = 0; k < size; ++k)
    shaken[k] = 0.02 * scene.grid.h * double(k % 7), direction[k] = float(k % 5);
  Room<double> u{int64_t(size)};
  Room<float> p{int64_t(size)}, kept{int64_t(size)}, anew{int64_t(size)};
  upload(shaken, u);
  upload(direction, p);
  // p, inertia, product; weights and rotations
  const double nodes = N * (12 + 8 + 12), voxels = V * 4 * 14;
  rows.add("projected Hessian", N * 24 + V * 4 * 45, [&] { potential.linearise(u.data); });
  rows.add("Hessian product", nodes + voxels + V * 4 * 45,
           [&] { potential.hessian_product(p.data, kept.data); });
  RecomputedHessian recomputed(potential);
  recomputed.linearise(u.data);
  rows.add("Hessian product, tangents anew", nodes + voxels + V * 4 * 9,
           [&] { recomputed.hessian_product(p.data, anew.data); });
  const double apart = relative_difference(download(anew, size), download(kept, size));
  ELASTOGEN_CHECK(apart < 1e-4, "the two Hessian products are ", apart, " apart");
}

}  // namespace

std::vector<KernelRow> card_kernels(const Scene& scene) {
  IncrementalPotential potential(scene);
  potential.begin_step(initial_state(scene), {TimeScheme::kEuler, scene.dt, 1});
  cuda::DeviceQuasi quasi(potential, EncoderChoice{}), without(potential, EncoderChoice{false});
  const auto V = double(scene.grid.voxel_count()), N = double(scene.grid.node_count());
  Room<double> u(int64_t(3 * N)), gradient(int64_t(3 * N));
  Room<float> r(int64_t(3 * N)), z(int64_t(3 * N)), single(int64_t(3 * N));
  for (cuda::DeviceQuasi* q : {&quasi, &without}) {
    q->begin_step(potential);
    q->set_nodal_rotations(potential.now().data());
  }
  Rows rows;
  // u, predictor, inertia, gradient; weights and rotations
  rows.add("energy and gradient, float", N * (24 + 24 + 8 + 12) + V * 4 * 14,
           [&] { quasi.potential().evaluate<float>(u.data, single.data); });
  rows.add("energy and gradient, double", N * (24 + 24 + 8 + 24) + V * 8 * 14,
           [&] { quasi.potential().evaluate<double>(u.data, gradient.data); });
  rows.add("nodal rotations", N * (3 * 24 + 3 * 36) + V * 4,
           [&] { quasi.potential().set_nodal_rotations(u.data); });
  add_hessians(scene, quasi.potential(), rows);
  // on the finest level start, residual, two smoothings and a correction of vectors of 12 B a node
  // and 4 B of row; an eighth of all below it; turned by rotations before and after
  const double levels = 8.0 / 7 * N * (40 + 31 + 28 + 40 + 52 + 44) + N * 2 * (12 + 36 + 12);
  rows.add("V-cycle, float", levels, [&] { without.precondition(r.data, z.data); });
  rows.add("V-cycle and encoder, float", levels + N * 2 * (84 + 12),
           [&] { quasi.precondition(r.data, z.data); });
  return rows.list;
}

}  // namespace elastogen::bench
