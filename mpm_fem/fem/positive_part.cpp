// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/positive_part.hpp"

#include "mpm_fem/fem/element_state.hpp"

#include <Eigen/Eigenvalues>

namespace elastogen::fem {

void clamp_eigenvalues(int size, double* K) {
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMaxDofs, 1>;
  using Matrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, kMaxDofs, kMaxDofs>;
  Matrix result = Eigen::Map<const Matrix>(K, size, size);
  const Eigen::SelfAdjointEigenSolver<Matrix> solver(result);
  for (Eigen::Index k = 0; k < size; ++k) {
    const double value = solver.eigenvalues()(k);
    if (value >= 0) break;
    const Vector direction = solver.eigenvectors().col(k);
    result -= value * (direction * direction.transpose());
  }
  mirror(size, result.data());
  Eigen::Map<Matrix>(K, size, size) = result;
}

}  // namespace elastogen::fem
