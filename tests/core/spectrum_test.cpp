// SPDX-License-Identifier: Apache-2.0
// Spectra of assembled operators: modes that one deformation gradient per voxel does not see on a
// clamped box, and the element bound on Jacobi's iteration with the strain-variance term.

#include "tests/support/eigenvalues.hpp"
#include "tests/support/element_assembly.hpp"
#include "tests/support/matrices.hpp"
#include "voxelize/bricks.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

using SparseMatrix = Eigen::SparseMatrix<double>;

/// Zero eigenvalues left when the plane x = 0 is held.
int clamped_nullity(const VoxelGrid& grid, const SparseMatrix& K) {
  std::vector<int> free;
  for (int64_t n = 0; n < grid.node_count(); ++n)
    for (int i = 0; i < 3; ++i)
      if (grid.node_coord(n, 0) > 0) free.push_back(int(3 * n + i));
  const Eigen::MatrixXd all = K;
  const Eigen::MatrixXd part = all(free, free);
  return int((test::eigenvalues(part).array() < 1e-10 * part.norm()).count());
}

/// Sum over the voxels of G^T G: zero where every F is zero.
SparseMatrix gradient_square(const Scene& scene) {
  return test::assemble(scene.grid, [&](int64_t v) {
    const VoxelData<double> data = test::voxel_data(scene, v);
    Eigen::MatrixXd G(9, 24);
    for (int col = 0; col < 24; ++col) {
      double u[3][8] = {};
      u[col % 3][col / 3] = 1;
      for (auto& component : u) hex8::to_patterns(component);
      const Mat3<double> F = deformation_gradient<false>(data, u);
      for (int k = 0; k < 9; ++k) G(k, col) = F.m[k] - (k % 4 == 0);
    }
    return Eigen::MatrixXd(G.transpose() * G);
  });
}

TEST(Spectrum, AClampedBeamHasModesWithoutGradientAndNoneWithTheVarianceTerm) {
  // 16x3x3 nodes: n_x - 1 = 15 a component without any gradient; another 15 in which F is a small
  // rotation that differs from voxel to voxel cost no elastic energy either
  const auto beam = [](Hourglass hourglass) {
    return test::box_scene(15, 2, 2, 1, {"test", Law::kNeoHookean, 1, 0.3, 1}, hourglass);
  };
  const Scene off = beam(Hourglass::kOff);
  EXPECT_EQ(clamped_nullity(off.grid, gradient_square(off)), 3 * 15);
  EXPECT_EQ(clamped_nullity(off.grid, test::rest_stiffness(off)), 4 * 15);
  for (const Hourglass hourglass : {Hourglass::kVariance, Hourglass::kFull}) {
    const Scene scene = beam(hourglass);
    EXPECT_EQ(clamped_nullity(scene.grid, test::rest_stiffness(scene)), 0);
  }
}

/// A block with holes, whose voxels have random fills.
VoxelGrid porous_grid() {
  test::Random random(3);
  std::vector<int32_t> kept;
  for (int k = 0; k < 8 * 8 * 8; ++k)
    if (random() % 5 > 0) kept.insert(kept.end(), {k % 8, k / 8 % 8, k / 64});
  VoxelGrid grid = make_grid({kept.data(), int64_t(kept.size() / 3), 3}, 1, {});
  std::uniform_real_distribution<double> fill(0.05, 1);
  for (int64_t v = 0; v < grid.voxel_count(); ++v) grid.fill(v) = fill(random);
  return grid;
}

/// Scalar operator sum_v phi h [K_1 + kappa (K_full - K_1)] by the element's own functions: the
/// gradient at the centre and the variance term of one component.
SparseMatrix scalar_operator(const VoxelGrid& grid, double kappa) {
  Eigen::Matrix<double, 8, 8> element;
  const double weight[4] = {kappa, kappa, kappa, kappa}, none[7] = {};
  // the element matrix, column by column
  for (int col = 0; col < 8; ++col) {
    double p[8] = {}, f[8] = {}, d[3], q[4], slope[4];
    p[col] = 1;
    hex8::to_patterns(p);
    hex8::gradient<false>(p, none, d);
    for (double& component : d) component /= 16;  // (1/4h)^2 h^3 with h = 1
    hex8::add_gradient_transposed<false>(d, none, f);
    hex8::centred_patterns<false>(p, none, q);
    hex8::variance(q, weight, slope);
    hex8::add_centred_transposed<false>(slope, none, f);
    hex8::to_corners(f);
    for (int row = 0; row < 8; ++row) element(row, col) = f[row];
  }
  // assembled with the fills as weights
  std::vector<Eigen::Triplet<double>> entries;
  for (int64_t v = 0; v < grid.voxel_count(); ++v)
    for (int row = 0; row < 8; ++row)
      for (int col = 0; col < 8; ++col)
        entries.emplace_back(grid.corners(v, row), grid.corners(v, col),
                             grid.fill(v) * element(row, col));
  SparseMatrix A(grid.node_count(), grid.node_count());
  A.setFromTriplets(entries.begin(), entries.end());
  return A;
}

/// Largest eigenvalue of D^-1 A, by power iteration and the Rayleigh quotient.
double largest_jacobi_eigenvalue(const SparseMatrix& A) {
  const Eigen::VectorXd D = A.diagonal();
  test::Random random(4);
  std::normal_distribution<double> normal;
  Eigen::VectorXd p(A.rows());
  for (double& value : p) value = normal(random);
  for (int k = 0; k < 3000; ++k) p = (A * p).cwiseQuotient(D).normalized();
  return p.dot(A * p) / p.dot(D.cwiseProduct(p));
}

TEST(Spectrum, JacobiIsBoundedByTheElementAndAttainsItsBound) {
  // max(4, 8 kappa/3) / (3/2 + 7 kappa/6); below 2 for 3/7 < kappa < 9
  const std::pair<double, double> table[] = {{0, 2.667},   {0.3, 2.162},   {3.0 / 7, 2.000},
                                             {0.5, 1.920}, {0.625, 1.794}, {1, 1.500},
                                             {2, 1.391},   {9, 2.000},     {12, 2.065}};
  const VoxelGrid grids[2] = {make_box(8, 8, 8, 1), porous_grid()};
  for (const auto& [kappa, bound] : table) {
    EXPECT_NEAR(std::max(4.0, 8 * kappa / 3) / (1.5 + 7 * kappa / 6), bound, 5e-4);
    for (const VoxelGrid& grid : grids)
      EXPECT_NEAR(largest_jacobi_eigenvalue(scalar_operator(grid, kappa)), bound, 2e-3) << kappa;
  }
}

}  // namespace
}  // namespace elastogen
