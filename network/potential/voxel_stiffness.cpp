// SPDX-License-Identifier: Apache-2.0
#include "network/potential/voxel_stiffness.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>

namespace elastogen {
namespace {

using Matrix9 = Eigen::Matrix<double, 9, 9>;

/// A tangent without its negative eigenvalues.
Matrix9 positive_part(const Matrix9& tangent) {
  if (Eigen::LLT<Matrix9>(tangent).info() == Eigen::Success) return tangent;
  const Eigen::SelfAdjointEigenSolver<Matrix9> eigen(tangent);
  return eigen.eigenvectors() * eigen.eigenvalues().cwiseMax(0).asDiagonal() *
         eigen.eigenvectors().transpose();
}

/// One value in all lanes.
using Lanes = Pack<double>;
VoxelData<Lanes> in_lanes(const VoxelData<double>& of) {
  VoxelData<Lanes> result;
  result.law = of.law;
  result.h = of.h;
  result.hourglass = of.hourglass;
  result.phi = constant<Lanes>(of.phi);
  for (int k = 0; k < 4; ++k) result.c[k] = constant<Lanes>(of.c[k]);
  for (int k = 0; k < 7; ++k) result.M[k] = constant<Lanes>(of.M[k]);
  for (int k = 0; k < 9; ++k) result.R[k] = constant<Lanes>(of.R[k]);
  return result;
}

}  // namespace

VoxelStiffness::VoxelStiffness(IncrementalPotential& potential, const double* u) : of_(potential) {
  of_.rotations(u, of_.gradients_);
}

Mat3<double> VoxelStiffness::frame(int64_t voxel) const {
  const size_t slot = size_t(of_.rows().slot[size_t(voxel)]), lane = slot % kLanes;
  Mat3<double> R;
  for (size_t k = 0; k < 9; ++k) R.m[k] = of_.gradients_[(slot - lane) * 9 + k * kLanes + lane];
  return R;
}

/// Data of one voxel, for what varies within it.
VoxelData<double> VoxelStiffness::data(int64_t voxel) const {
  const Scene& scene = of_.scene();
  const size_t slot = size_t(of_.rows().slot[size_t(voxel)]), lane = slot % kLanes;
  VoxelData<double> data;
  data.h = scene.grid.h;
  data.hourglass = scene.hourglass;
  data.law.mu = scene.materials[size_t(scene.material(voxel))].mu();
  const double* w = of_.weights_.data() + (slot - lane) * 5 + lane;
  data.phi = w[0];
  for (size_t k = 0; k < 4; ++k) data.c[k] = w[(k + 1) * kLanes];
  hex8::fill_moments(scene.grid.shape_mean.row(voxel), data.M);
  for (size_t k = 0; k < 9; ++k) data.R[k] = of_.rotation_[(slot - lane) * 9 + k * kLanes + lane];
  return data;
}

void VoxelStiffness::matrix(int64_t voxel, double* K) const {
  // the tangent
  const size_t slot = size_t(of_.rows().slot[size_t(voxel)]), lane = slot % kLanes;
  Matrix9 T;
  const float* upper = of_.tangent_.data() + (slot - lane) * 45 + lane;
  for (int row = 0, k = 0; row < 9; ++row)
    for (int col = row; col < 9; ++col, ++k) T(row, col) = T(col, row) = double(upper[k * kLanes]);
  T = positive_part(T);
  Tangent<Lanes> tangent;
  for (int row = 0, k = 0; row < 9; ++row)
    for (int col = row; col < 9; ++col) tangent.m[k++] = constant<Lanes>(T(row, col));
  // products with unit vectors, a column in each lane
  const VoxelData<Lanes> of = in_lanes(data(voxel));
  const double beta = of_.beta_of(of_.scene().material(voxel));
  for (int first = 0; first < 24; first += kLanes) {
    Lanes p[3][8] = {}, f[3][8];
    for (int l = 0; l < kLanes; ++l) p[(first + l) % 3][(first + l) / 3][l] = 1;
    voxel_hessian<true>(of, tangent, p, f, beta);
    for (int row = 0; row < 24; ++row) store<double>(K + 24 * row + first, f[row % 3][row / 3]);
  }
}

}  // namespace elastogen
