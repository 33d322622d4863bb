// SPDX-License-Identifier: Apache-2.0
// The one instantiation of Eigen's symmetric eigenvalue decomposition (it compiles slowly).

#pragma once

#include <Eigen/Core>

namespace elastogen::test {

/// Eigenvalues of a symmetric matrix in ascending order.
Eigen::VectorXd eigenvalues(const Eigen::MatrixXd& symmetric);

/// A symmetric matrix with its negative eigenvalues set to 0.
Eigen::MatrixXd clamped(const Eigen::MatrixXd& symmetric);

}  // namespace elastogen::test
