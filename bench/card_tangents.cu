// SPDX-License-Identifier: Apache-2.0
#include "bench/card_tangents.hpp"
#include "network/potential/incremental_potential.cuh"

namespace elastogen::bench {

using cuda::DeviceArray;
using cuda::VoxelTables;

struct RecomputedHessian::Impl {
  explicit Impl(cuda::DevicePotential::Impl& p)
      : potential(p), gradient(p.rows.row_count() * 9 * kLanes) {}

  void linearise(const double* u);
  void hessian_product(const float* p, float* product);

  cuda::DevicePotential::Impl& potential;
  DeviceArray<float> gradient;  // F_v, [row][9][lane]
};

void RecomputedHessian::Impl::linearise(const double* u) {
  float* to = gradient.data();
  const VoxelTables<float> table = potential.voxels<float>();
  cuda::for_each_voxel<float>(
      potential.rows, reinterpret_cast<float*>(potential.parts.data()),
      static_cast<NoSums*>(nullptr),
      [=] __device__(int64_t n, int64_t reference, float v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = float(u[3 * n + i] - u[3 * reference + i]);
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, float corner[3][8], float[3][8],
                     NoSums&) {
        const VoxelData<float> data = table.data(row, r, lane);
        for (int i = 0; i < 3; ++i) hex8::to_patterns(corner[i]);
        const Mat3<float> F = deformation_gradient<true>(data, corner);
        for (int k = 0; k < 9; ++k) to[(r * 9 + k) * kLanes + lane] = F.m[k];
      },
      cuda::NoFinish{});
}

void RecomputedHessian::Impl::hessian_product(const float* p, float* product) {
  const float* from = gradient.data();
  const VoxelTables<float> table = potential.voxels<float>();
  const double* mass = potential.inertia.data();
  const uint8_t* held = potential.pinned.data();
  cuda::for_each_voxel<float>(
      potential.rows, reinterpret_cast<float*>(potential.parts.data()),
      static_cast<NoSums*>(nullptr),
      [=] __device__(int64_t n, int64_t, float v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = p[3 * n + i];
      },
      // decompose the stored F again and apply the positive part of its Hessian
      [=] __device__(const VoxelRow& row, int64_t r, int lane, const float corner[3][8],
                     float f[3][8], NoSums&) {
        const VoxelData<float> data = table.data(row, r, lane);
        Mat3<float> F;
        for (int k = 0; k < 9; ++k) F.m[k] = from[(r * 9 + k) * kLanes + lane];
        const Svd3<float> svd = svd3(F);
        const Response<float> response = elastic_response<true>(data.law, svd.sigma);
        const auto H = positive_part(principal_hessian(svd.sigma, response));
        const auto stress = [&](const float dF[9], float dP[9]) {
          Mat3<float> change;
          for (int k = 0; k < 9; ++k) change.m[k] = dF[k];
          const Mat3<float> result = apply(H, svd, change);
          for (int k = 0; k < 9; ++k) dP[k] = result.m[k];
        };
        elastogen::hessian_product<true>(data, stress, corner, f);
      },
      // add inertia; rows of pinned nodes are 0
      [=] __device__(int64_t n, const cuda::NodeSum<float>& given) {
        float force[3];
        given.get(force);
        for (int i = 0; i < 3; ++i)
          product[3 * n + i] = held[n] ? 0.f : force[i] + float(mass[n]) * p[3 * n + i];
      });
}

RecomputedHessian::RecomputedHessian(cuda::DevicePotential& potential)
    : impl_(std::make_unique<Impl>(potential.impl())) {}

RecomputedHessian::~RecomputedHessian() = default;

void RecomputedHessian::linearise(const double* u) {
  impl_->linearise(u);
}

void RecomputedHessian::hessian_product(const float* p, float* product) {
  impl_->hessian_product(p, product);
}

}  // namespace elastogen::bench
