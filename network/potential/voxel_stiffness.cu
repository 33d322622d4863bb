// SPDX-License-Identifier: Apache-2.0
#include "core/polar.hpp"
#include "network/potential/voxel_stiffness.cuh"

#include <algorithm>

namespace elastogen::cuda {
namespace {

/// Frames of all voxels at u, by slot; 0 where there is no unique one.
void find_frames(DevicePotential::Impl& of, const double* u, Quaternion<float>* to) {
  const VoxelTables<float> table = of.voxels<float>();
  for_each_voxel<float>(
      of.rows, reinterpret_cast<float*>(of.parts.data()), static_cast<NoSums*>(nullptr),
      [=] __device__(int64_t n, int64_t reference, float v[3]) {
        for (int i = 0; i < 3; ++i) v[i] = float(u[3 * n + i] - u[3 * reference + i]);
      },
      [=] __device__(const VoxelRow& row, int64_t r, int lane, float corner[3][8], float[3][8],
                     NoSums&) {
        const VoxelData<float> data = table.data(row, r, lane);
        for (int i = 0; i < 3; ++i) hex8::to_patterns(corner[i]);
        const Mat3<float> R = unique_rotation(deformation_gradient<true>(data, corner));
        float size = 0;
        for (int k = 0; k < 9; ++k) size += fabsf(R.m[k]);
        to[r * kLanes + lane] = size > 0 ? quaternion_of(R) : Quaternion<float>{};
      },
      NoFinish{});
}

/// Sets the flags of voxels that have a node whose frame lies farther away.
void find_flags(DevicePotential::Impl& of, const Quaternion<float>* frame, float cosine,
                uint8_t* flag) {
  const Quaternion<float>* rotation = of.nodal_rotation.data();
  for_each_voxel<float>(
      of.rows, reinterpret_cast<float*>(of.parts.data()), static_cast<NoSums*>(nullptr),
      // a rotation as three numbers: those of its quaternion with w >= 0
      [=] __device__(int64_t n, int64_t, float v[3]) {
        const Quaternion<float> q = rotation[n];
        const float sign = q.w < 0 ? -1.f : 1.f;
        v[0] = sign * q.x, v[1] = sign * q.y, v[2] = sign * q.z;
      },
      [=] __device__(const VoxelRow&, int64_t r, int lane, const float corner[3][8], float[3][8],
                     NoSums&) {
        const Quaternion<float> q = frame[r * kLanes + lane];
        bool far = false;
        for (int c = 0; c < 8; ++c) {
          const float x = corner[0][c], y = corner[1][c], z = corner[2][c];
          const float left = 1 - x * x - y * y - z * z, w = left > 0 ? sqrtf(left) : 0.f;
          const float half = q.w * w + q.x * x + q.y * y + q.z * z;  // cosine of half the angle
          far |= 2 * half * half - 1 < cosine;
        }
        flag[r * kLanes + lane] = far;
      },
      NoFinish{});
}

}  // namespace

/// Tables of the host: the device keeps none by voxel.
void DeviceVoxelStiffness::find_slots() {
  if (!slot_.empty()) return;
  const BrickRows rows = make_brick_rows(of_.terms.scene());
  slot_.assign(rows.slot.begin(), rows.slot.end());
  voxel_.assign(rows.voxel.begin(), rows.voxel.end());
  frames_.resize(int64_t(voxel_.size()));
  flags_.resize(int64_t(voxel_.size()));
  sums_.resize(1);
}

std::vector<int32_t> DeviceVoxelStiffness::apart(const double* u, double cosine) {
  find_slots();
  find_frames(of_, u, frames_.data());
  find_flags(of_, frames_.data(), float(cosine), flags_.data());
  // most often there are none
  const uint8_t* flag = flags_.data();
  double* to = count_.data();
  const Signal::Raise raise = signal_.next();
  ordered_sum(
      flags_.size(), sums_.data(),
      [=] __device__(int64_t k, Sums<1> & sum) { sum.value[0] += flag[k]; },
      [=] __device__(const Sums<1>& sum) { *to = sum.value[0], raise(); });
  signal_.wait();
  std::vector<int32_t> voxels;
  if (count_[0] == 0) return voxels;
  const std::vector<uint8_t> flags = flags_.download();
  for (size_t k = 0; k < flags.size(); ++k)
    if (flags[k] != 0) voxels.push_back(voxel_[k]);
  std::ranges::sort(voxels);
  return voxels;
}

void DeviceVoxelStiffness::update(const double* u, const std::vector<int32_t>& voxels) {
  std::vector<int32_t> of_voxels(voxels.size());
  std::ranges::transform(voxels, of_voxels.begin(), [&](int32_t v) { return slot_[size_t(v)]; });
  slots_.upload(of_voxels);
  const int64_t count = slots_.size();
  matrices_.resize(count * kEntries);
  of_.linearise(u, TangentKind::kProjected);
  // a column of a matrix is the product with a unit vector
  const VoxelTables<float> table = of_.voxels<float>();
  const VoxelRow* rows = of_.rows.view().rows;
  const float* tangent = of_.tangent.data();
  const int32_t* slots = slots_.data();
  float* matrices = matrices_.data();
  const double per_step = of_.rate;
  cuda::for_each(24 * count, [=] __device__(int64_t k) {
    const int64_t of = k / 24, r = slots[of] / kLanes;
    const int column = int(k % 24), lane = slots[of] % kLanes;
    const VoxelRow row = rows[r];
    Tangent<float> t;
    for (int m = 0; m < 45; ++m) t.m[m] = tangent[(r * 45 + m) * kLanes + lane];
    float p[3][8] = {}, f[3][8] = {};
    p[column % 3][column / 3] = 1;
    const float beta = float(per_step * table.materials[row.material].viscous_time);
    voxel_hessian<true>(table.data(row, r, lane), t, p, f, beta);
    for (int m = 0; m < 24; ++m) matrices[kEntries * of + 24 * column + m] = f[m % 3][m / 3];
  });
}

}  // namespace elastogen::cuda
