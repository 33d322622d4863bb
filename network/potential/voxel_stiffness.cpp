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

/// 4 h times the gradient of each corner's shape function, the mean over the fill.
void shape_gradients(const double M[7], double gradient[8][3]) {
  for (int c = 0; c < 8; ++c) {
    double unit[8] = {};
    unit[c] = 1;
    hex8::to_patterns(unit);
    hex8::gradient<true>(unit, M, gradient[c]);
  }
}

}  // namespace

VoxelStiffness::VoxelStiffness(IncrementalPotential& potential, const double* u) : of_(potential) {
  of_.rotations(u, of_.gradients_);
  const Scene& scene = of_.scene();
  if (!scene.dependent.empty()) is_parent_.resize(size_t(scene.grid.node_count()));
  for (const int32_t n : scene.dependent.folded().nodes) is_parent_[size_t(n)] = 1;
}

bool VoxelStiffness::is_plain(int64_t node) const {
  return of_.scene().pinned(node) == kFreeNode && of_.held().fixed_axes(node) == 0 &&
         (is_parent_.empty() || !is_parent_[size_t(node)]);
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
  const size_t slot = size_t(of_.rows().slot[size_t(voxel)]), lane = slot % kLanes;
  const VoxelData<double> of = data(voxel);
  Matrix9 T;
  const float* upper = of_.tangent_.data() + (slot - lane) * 45 + lane;
  for (int row = 0, k = 0; row < 9; ++row)
    for (int col = row; col < 9; ++col, ++k) T(row, col) = T(col, row) = double(upper[k * kLanes]);
  // elasticity: G^T T G
  double gradient[8][3];
  shape_gradients(of.M, gradient);
  Eigen::Matrix<double, 9, 24> G = Eigen::Matrix<double, 9, 24>::Zero();
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i)
      for (int d = 0; d < 3; ++d) G(3 * i + d, 3 * c + i) = gradient[c][d];
  Eigen::Map<Eigen::Matrix<double, 24, 24, Eigen::RowMajor>> result(K);
  result.noalias() = G.transpose() * (of.phi * of.h / 16 * positive_part(T)) * G;
  // what varies within the voxel, column by column
  const double beta = of_.beta_of(of_.scene().material(voxel));
  for (int j = 0; j < 24; ++j) {
    double p[3][8] = {}, f[3][8] = {};
    p[j % 3][j / 3] = 1;
    for (auto& line : p) hex8::to_patterns(line);
    hourglass_energy<true>(of, p, f);
    if (beta > 0) add_variance_product<true>(of, beta, p, f);
    for (auto& line : f) hex8::to_corners(line);
    for (int i = 0; i < 24; ++i) result(i, j) += f[i % 3][i / 3];
  }
}

}  // namespace elastogen
