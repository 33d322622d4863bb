// SPDX-License-Identifier: Apache-2.0
#include "network/law/learned_law_impl.hpp"
#include "network/potential/incremental_potential.cuh"

namespace elastogen::cuda {
namespace {

constexpr int kWarp = 32, kWarps = 4, kWidth = NeuralMtl::kWidth, kUnits = kWidth / kWarp;

/// The layers of NetView::weights.
struct Layers {
  const float *w1, *b1, *w2, *b2, *w3, *b3;
  __device__ explicit Layers(const float* w)
      : w1(w),
        b1(w1 + 3 * kWidth),
        w2(b1 + kWidth),
        b2(w2 + kWidth * kWidth),
        w3(b2 + kWidth),
        b3(w3 + kWidth) {}
};

/// The sum over a warp, for every lane.
__device__ inline double warp_sum(double value) {
  for (int offset = kWarp / 2; offset > 0; offset /= 2)
    value += __shfl_xor_sync(0xffffffff, value, offset);
  return value;
}

/// f and its derivatives in x at one x, by a warp. Each lane has four units of either layer. A jet
/// is a value and its derivatives, kChannels numbers. The jets of the first layer go through
/// `hidden`, (kWidth, kChannels) in shared memory, so that every lane reads all of them for the
/// second layer. The output is a sum over the warp, which every lane gets.
template <int kChannels>
__device__ inline void net_jets(const Layers& net, int lane, const double x[3], double* hidden,
                                double f[kChannels]) {
  // first layer, into shared memory
  for (int j = 0; j < kUnits; ++j) {
    const int k = lane + j * kWarp;
    double z[kChannels];
    mtl::first_unit<kChannels>(net.w1 + 3 * k, net.b1[k], x, z);
    for (int c = 0; c < kChannels; ++c) hidden[k * kChannels + c] = z[c];
  }
  __syncwarp();
  // second layer, over all units of the first
  double z[kUnits][kChannels] = {};
#pragma unroll 4
  for (int m = 0; m < kWidth; ++m)
    for (int j = 0; j < kUnits; ++j) {
      const auto w = double(net.w2[m * kWidth + lane + j * kWarp]);
      for (int c = 0; c < kChannels; ++c) z[j][c] = fma(w, hidden[m * kChannels + c], z[j][c]);
    }
  __syncwarp();
  // output, a sum over the lanes
  for (int c = 0; c < kChannels; ++c) f[c] = 0;
  for (int j = 0; j < kUnits; ++j) {
    const int k = lane + j * kWarp;
    z[j][0] += double(net.b2[k]);
    mtl::activate<kChannels>(z[j]);
    for (int c = 0; c < kChannels; ++c) f[c] += double(net.w3[k]) * z[j][c];
  }
  for (int c = 0; c < kChannels; ++c) f[c] = warp_sum(f[c]);
  f[0] += double(*net.b3);
}

/// The correction of a net at e, from f and its derivatives for the three axes, kChannels each.
template <bool kHessian>
__device__ inline LogJet added_by_net(const DeviceMaterial& m, const double e[3], const double* f) {
  constexpr int kChannels = kHessian ? 10 : 4;
  mtl::Strain s[3];
#pragma unroll
  for (int i = 0; i < 3; ++i) s[i] = mtl::strain<kHessian>(e, i, f + i * kChannels, m.net.terms);
  const LogJet theta = mtl::energy<kHessian>(s, m.net.terms.omega);
  return learned::difference({m.law.law, m.net.mu, m.net.lambda}, e, theta);
}

/// f and its derivatives for the three axes at the log stretches of a voxel, [axis][channel], by a
/// warp.
template <int kChannels>
__device__ inline void voxel_jets(const Layers& net, int lane, const double e[3], double* hidden,
                                  double* f) {
  for (int i = 0; i < 3; ++i) {
    double x[3], jet[kChannels];
    mtl::inputs(e, i, x);
    net_jets<kChannels>(net, lane, x, hidden, jet);
    if (lane == 0)
      for (int c = 0; c < kChannels; ++c) f[i * kChannels + c] = jet[c];
  }
}

/// Corrections of a row of eight voxels, one warp for each row. The whole warp evaluates the net at
/// one voxel after another, and leaves f and its derivatives in shared memory; it skips voxels
/// where the correction has weight 0. Then each of the first eight lanes makes the correction of
/// its own voxel from them and stores it.
template <bool kHessian>
__global__ void __launch_bounds__(kWarp* kWarps)
    net_kernel(int64_t rows, const VoxelRow* row_of, const DeviceMaterial* materials,
               const double* logs, double* results) {
  constexpr int kChannels = kHessian ? 10 : 4, kFields = kHessian ? kNetFields : 4;
  __shared__ __align__(16) double hidden[kWarps][kWidth * kChannels];
  __shared__ double f[kWarps][kLanes][3 * kChannels];
  const int warp = int(threadIdx.x) / kWarp, lane = int(threadIdx.x) % kWarp;
  const int64_t r = int64_t(blockIdx.x) * kWarps + warp;
  begin_kernel();
  if (r >= rows) return;
  const VoxelRow row = row_of[r];
  const DeviceMaterial& material = materials[row.material];
  if (!material.net.weights) return;
  const double* asked = logs + r * 3 * kLanes;
  // log stretches of this lane's voxel, and whether the net has weight there
  const bool mine = lane < kLanes && (row.mask >> lane & 1);
  double e[3] = {};
  if (mine)
    for (int i = 0; i < 3; ++i) e[i] = asked[i * kLanes + lane];
  const bool reached = mine && learned::weight(material.law.law, e).psi > 0;
  const unsigned all_reached = __ballot_sync(0xffffffff, reached);
  // the net at each voxel in turn
  for (int v = 0; v < kLanes; ++v) {
    const double at[3] = {asked[v], asked[kLanes + v], asked[2 * kLanes + v]};
    if (all_reached >> v & 1)
      voxel_jets<kChannels>(Layers(material.net.weights), lane, at, hidden[warp], f[warp][v]);
  }
  __syncwarp();
  if (!mine) return;
  // each lane's own correction
  const LogJet jet = reached ? added_by_net<kHessian>(material, e, f[warp][lane]) : LogJet{};
  double* to = results + r * kNetFields * kLanes + lane;
  to[0] = jet.psi;
  for (int i = 0; i < 3; ++i) to[(1 + i) * kLanes] = jet.w[i];
  for (int c = 4; c < kFields; ++c) to[c * kLanes] = jet.ww[c - 4];
}

}  // namespace

template <bool kHessian>
void evaluate_nets(const DeviceRows& rows, const DeviceMaterial* materials, const double* logs,
                   double* results) {
  const int64_t count = rows.row_count();
  if (count == 0) return;
  launch(net_kernel<kHessian>, unsigned((count + kWarps - 1) / kWarps), kWarp * kWarps, 0, count,
         rows.view().rows, materials, logs, results);
}

template <class T, NetPass kPass>
void DevicePotential::Impl::ask_nets(const double* u) {
  const VoxelTables<T> table = voxels<T>();
  const NetQuestions questions{materials.data(), logs.data()};
  for_each_voxel<T>(
      rows, reinterpret_cast<T*>(parts.data()), static_cast<NoSums*>(nullptr),
      [=] __device__(int64_t n, int64_t reference, T v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = T(u[3 * n + i] - u[3 * reference + i]);
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, T corner[3][8], T f[3][8], NoSums&) {
        const VoxelData<T> data = table.data(row, r, lane);
        const auto respond = response_of<false>(data.law, questions(row, r, lane));
        if constexpr (kPass == NetPass::kEnergy) {
          voxel_energy<true>(data, respond, corner, f);
        } else {
          for (int i = 0; i < 3; ++i) hex8::to_patterns(corner[i]);
          const Svd3<T> F = svd3(deformation_gradient<true>(data, corner));
          T outside;
          respond(F.sigma, outside);
        }
      },
      NoFinish{});
  evaluate_nets<kPass == NetPass::kTangent>(rows, materials.data(), logs.data(), results.data());
}

template void DevicePotential::Impl::ask_nets<float, NetPass::kEnergy>(const double*);
template void DevicePotential::Impl::ask_nets<double, NetPass::kEnergy>(const double*);
template void DevicePotential::Impl::ask_nets<float, NetPass::kTangent>(const double*);
template void DevicePotential::Impl::ask_nets<double, NetPass::kStretches>(const double*);

}  // namespace elastogen::cuda
