// SPDX-License-Identifier: Apache-2.0
#include "network/potential/incremental_potential.cuh"

namespace elastogen::cuda {

template <class Nets>
void DevicePotential::Impl::tangent_pass(const double* u, TangentKind kind, const Nets& nets) {
  float* to = tangent.data();
  const VoxelTables<float> table = voxels<float>();
  for_each_voxel<float>(
      rows, reinterpret_cast<float*>(parts.data()), static_cast<NoSums*>(nullptr),
      [=] __device__(int64_t n, int64_t reference, float v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = float(u[3 * n + i] - u[3 * reference + i]);
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, const float corner[3][8],
                     float[3][8], NoSums&) {
        const VoxelData<float> data = table.data(row, r, lane);
        const auto respond = response_of<true>(data.law, nets(row, r, lane));
        const Tangent<float> t = voxel_tangent<true>(data, respond, corner, kind);
        for (int k = 0; k < 45; ++k) to[(r * 45 + k) * kLanes + lane] = t.m[k];
      },
      NoFinish{});
}

void DevicePotential::Impl::linearise(const double* u, TangentKind kind) {
  if (tangent.size() == 0) tangent = DeviceArray<float>(rows.row_count() * 45 * kLanes);
  with_nets<float, NetPass::kTangent>(u, [&](const auto& nets) { tangent_pass(u, kind, nets); });
  if (terms.has_damping()) viscous_tangent_pass(u, kind);
}

/// @param kDamped  false: no material is damped.
template <bool kDamped, class T>
void DevicePotential::Impl::tangent_product(const T* p, T* product) {
  // what kernels read; the product of a voxel, then that of a node with its inertia
  const float* from = tangent.data();
  const VoxelTables<T> table = voxels<T>();
  const double* mass = inertia.data();
  const uint8_t* kind = pinned.data();
  const double per_step = rate;
  for_each_voxel<T>(
      rows, reinterpret_cast<T*>(parts.data()), static_cast<NoSums*>(nullptr),
      [=] __device__(int64_t n, int64_t, T v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = p[3 * n + i];
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, const T corner[3][8], T f[3][8],
                     NoSums&) {
        Tangent<T> t;
        for (int k = 0; k < 45; ++k) t.m[k] = T(from[(r * 45 + k) * kLanes + lane]);
        const T beta = kDamped ? T(per_step * table.materials[row.material].viscous_time) : T(0);
        voxel_hessian<true>(table.data(row, r, lane), t, corner, f, beta);
      },
      [=] __device__(int64_t n, const NodeSum<T>& given) {
        T force[3];
        given.get(force);
        for (int i = 0; i < 3; ++i)
          product[3 * n + i] = kind[n] == kPinnedNode ? T(0) : force[i] + T(mass[n]) * p[3 * n + i];
      });
}

template <class T>
void DevicePotential::Impl::hessian_product(const T* p, T* product) {
  if (terms.has_damping())
    tangent_product<true>(p, product);
  else
    tangent_product<false>(p, product);
}

void DevicePotential::linearise(const double* u, TangentKind kind, bool touching) {
  impl_->linearise(u, kind);
  if (impl_->contact) impl_->contact->linearise(u, touching);
}

template <class T>
void DevicePotential::hessian_product(const T* p, T* product) {
  impl_->hessian_product(p, product);
  if (impl_->contact) impl_->contact->add_hessian_product(p, product);
  impl_->held.fold(product);
}

template void DevicePotential::hessian_product(const float*, float*);
template void DevicePotential::hessian_product(const double*, double*);

size_t DevicePotential::tangent_bytes() const {
  return size_t(impl_->rows.row_count()) * 45 * kLanes * sizeof(float);
}

}  // namespace elastogen::cuda
