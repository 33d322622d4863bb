// SPDX-License-Identifier: Apache-2.0
// Damping on the device (voxel_damping.hpp): passes of their own, so that scenes without it have the
// kernels that they had.
#include "network/potential/incremental_potential.cuh"

namespace elastogen::cuda {
namespace {

constexpr int64_t kStrains = VoxelStrain<double>::kCount;

/// E_b, A_b and beta of the voxels, as kernels read them.
template <class T>
struct DampingTables {
  const double* before;  ///< [row][18][lane]
  const DeviceMaterial* materials;
  double rate;  ///< 1/k [1/s]

  __device__ T beta(const VoxelRow& row) const {
    return T(rate * materials[row.material].viscous_time);
  }
  __device__ VoxelDamping<T> at(const VoxelRow& row, int64_t r, int lane) const {
    VoxelDamping<T> d;
    d.beta = beta(row);
    const double* const from = before + r * kStrains * kLanes + lane;
    for (int k = 0; k < 6; ++k) d.before.E[k] = T(from[k * kLanes]);
    for (int k = 0; k < 12; ++k) d.before.A[k / 4][k % 4] = T(from[(6 + k) * kLanes]);
    return d;
  }
};

}  // namespace

/// Strains of every voxel at displacement u.
void DevicePotential::Impl::find_strains(const double* u, double* to) {
  const VoxelTables<double> table = voxels<double>();
  for_each_voxel<double>(
      rows, parts.data(), static_cast<NoSums*>(nullptr),
      [=] __device__(int64_t n, int64_t reference, double v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = u[3 * n + i] - u[3 * reference + i];
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, const double corner[3][8],
                     double[3][8], NoSums&) {
        const VoxelStrain<double> strain = voxel_strain<true>(table.data(row, r, lane), corner);
        double* const at = to + r * kStrains * kLanes + lane;
        for (int k = 0; k < 6; ++k) at[k * kLanes] = strain.E[k];
        for (int k = 0; k < 12; ++k) at[(6 + k) * kLanes] = strain.A[k / 4][k % 4];
      },
      NoFinish{});
}

/// IncrementalPotential::begin_damping.
void DevicePotential::begin_damping(const StepScheme& scheme, const double* now,
                                    const double* other) {
  Impl& s = *impl_;
  if (!s.terms.has_damping()) return;
  s.rate = rate_of(scheme);
  s.find_strains(now, s.strain_before.data());
  const double weight = scheme.is_stage                      ? scheme.stage.w_v
                        : scheme.scheme == TimeScheme::kBdf2 ? -1.0 / 3
                                                             : 0;
  if (weight == 0) return;
  s.find_strains(other, s.strains.data());
  double* const to = s.strain_before.data();
  const double* const from = s.strains.data();
  cuda::for_each(s.strains.size(),
                 [=] __device__(int64_t k) { to[k] += weight * (from[k] - to[k]); });
}

/// Adds the viscous part to the gradient, unless that is null, and notes its value.
/// @param at_pinned  whether pinned nodes get theirs.
template <class T>
void DevicePotential::Impl::viscous_pass(const double* u, T* gradient, int place, bool at_pinned) {
  // what kernels read, what they do with a voxel and a node, and the loop
  const VoxelTables<T> table = voxels<T>();
  const DampingTables<T> damping{strain_before.data(), materials.data(), rate};
  const uint8_t* kind = pinned.data();
  DeviceValue* to = value.data() + place;
  const auto read = [=] __device__(int64_t n, int64_t reference, T v[3]) {
    for (int i = 0; i < 3; ++i) v[i] = T(u[3 * n + i] - u[3 * reference + i]);
  };
  const auto voxel = [=] __device__(const VoxelRow& row, int64_t r, int lane, const T corner[3][8],
                                    T f[3][8], VoxelSums& sums) {
    for (int i = 0; i < 3; ++i)
      for (int c = 0; c < 8; ++c) f[i][c] = 0;
    if (!(damping.beta(row) > 0)) return;
    VoxelSums mine;
    mine.elastic =
        double(damping_force<true>(table.data(row, r, lane), damping.at(row, r, lane), corner, f));
    sums.add(mine);
  };
  const auto finish = [=] __device__(int64_t n, const NodeSum<T>& given) {
    T force[3];
    given.get(force);
    const bool counts = at_pinned || kind[n] != kPinnedNode;
    for (int i = 0; i < 3; ++i) gradient[3 * n + i] += counts ? force[i] : T(0);
  };
  const auto then = [=] __device__(const VoxelSums& sum) { to->viscous = sum.elastic; };
  T* const scratch = reinterpret_cast<T*>(parts.data());
  if (gradient == nullptr)
    for_each_voxel<T>(rows, scratch, brick_sums.data(), read, voxel, NoFinish{}, then);
  else
    for_each_voxel<T>(rows, scratch, brick_sums.data(), read, voxel, finish, then);
}

template void DevicePotential::Impl::viscous_pass<float>(const double*, float*, int, bool);
template void DevicePotential::Impl::viscous_pass<double>(const double*, double*, int, bool);

/// Adds the viscous part to the tangents.
void DevicePotential::Impl::viscous_tangent_pass(const double* u, TangentKind kind) {
  float* const to = tangent.data();
  const VoxelTables<float> table = voxels<float>();
  const DampingTables<float> damping{strain_before.data(), materials.data(), rate};
  for_each_voxel<float>(
      rows, reinterpret_cast<float*>(parts.data()), static_cast<NoSums*>(nullptr),
      [=] __device__(int64_t n, int64_t reference, float v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = float(u[3 * n + i] - u[3 * reference + i]);
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, float corner[3][8], float[3][8],
                     NoSums&) {
        if (!(damping.beta(row) > 0)) return;
        // column by column, the upper triangle
        const VoxelData<float> data = table.data(row, r, lane);
        for (int i = 0; i < 3; ++i) hex8::to_patterns(corner[i]);
        const Mat3<float> H = displacement_gradient<true>(data, corner);
        const VoxelDamping<float> d = damping.at(row, r, lane);
        for (int line = 0, k = 0; line < 9; ++line) {
          Mat3<float> unit{}, column{};
          unit.m[line] = 1;
          add_viscous_tangent(d.moduli(data), H, d.before.E, kind, unit, column);
          for (int col = line; col < 9; ++col, ++k)
            to[(r * 45 + k) * kLanes + lane] += column.m[col];
        }
      },
      NoFinish{});
}

}  // namespace elastogen::cuda
