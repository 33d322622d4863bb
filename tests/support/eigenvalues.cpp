// SPDX-License-Identifier: Apache-2.0
#include "tests/support/eigenvalues.hpp"

#include <Eigen/Eigenvalues>

namespace elastogen::test {

Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric) {
  return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(symmetric, Eigen::EigenvaluesOnly)
      .eigenvalues();
}

Eigen::MatrixXd clamped(const Eigen::MatrixXd& symmetric) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(symmetric);
  const Eigen::MatrixXd& Q = solver.eigenvectors();
  return Q * solver.eigenvalues().cwiseMax(0.0).asDiagonal() * Q.transpose();
}

}  // namespace elastogen::test
