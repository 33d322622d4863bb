// SPDX-License-Identifier: Apache-2.0
#include "io/modal_basis.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>

namespace elastogen {

namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

/// Vertices that are held at once, for all frames.
int64_t block_size(const Motion& motion) {
  return std::clamp<int64_t>((int64_t{1} << 21) / std::max<int64_t>(motion.frames, 1), 64, 1 << 16);
}

/// Calls f(first, D) for blocks of vertices; row t of D is frame t [m], (frames, 3 vertices).
template <class F>
void for_each_block(const Motion& motion, const F& f) {
  std::vector<float> row;
  for (int64_t first = 0; first < motion.vertices; first += block_size(motion)) {
    const int64_t count = std::min(block_size(motion), motion.vertices - first);
    Matrix D(motion.frames, 3 * count);
    row.resize(size_t(3 * count));
    for (int64_t t = 0; t < motion.frames; ++t) {
      motion.read(t, first, count, row.data());
      D.row(t) = Eigen::Map<const Eigen::RowVectorXf>(row.data(), 3 * count).cast<double>();
    }
    f(first, D);
  }
}

/// Which frames move at all.
std::vector<int64_t> moving_frames(const Motion& motion) {
  std::vector<char> moves(size_t(motion.frames), 0);
  for_each_block(motion, [&](int64_t, const Matrix& D) {
    for (int64_t t = 0; t < motion.frames; ++t) moves[size_t(t)] |= !D.row(t).isZero(0);
  });
  std::vector<int64_t> frames;
  for (int64_t t = 0; t < motion.frames; ++t) {
    if (moves[size_t(t)]) frames.push_back(t);
  }
  return frames;
}

/// At most 256 of the frames, evenly spaced, the last one included.
std::vector<int64_t> chosen_snapshots(const std::vector<int64_t>& moving) {
  const auto n = int64_t(moving.size()), count = std::min<int64_t>(n, kMaxSnapshots);
  std::vector<int64_t> snapshots;
  for (int64_t s = 1; s <= count; ++s) snapshots.push_back(moving[size_t(s * n / count - 1)]);
  return snapshots;
}

Matrix chosen_rows(const Matrix& D, const std::vector<int64_t>& rows) {
  Matrix result(rows.size(), D.cols());
  for (size_t r = 0; r < rows.size(); ++r) result.row(Eigen::Index(r)) = D.row(rows[r]);
  return result;
}

/// Modes of a block of vertices from its frames D [m], (modes, 3 vertices).
Matrix modes_of(const Matrix& D, const ModalBasis& basis) {
  if (basis.shares.empty()) return chosen_rows(D, basis.snapshots);
  const Eigen::Map<const Matrix> shares(basis.shares.data(), basis.shares.rows(), basis.modes());
  return shares.transpose() * chosen_rows(D, basis.snapshots);
}

/// Inner products of all frames with the snapshots [m^2], (frames, snapshots).
Matrix inner_products(const Motion& motion, const std::vector<int64_t>& snapshots) {
  Matrix C = Matrix::Zero(motion.frames, Eigen::Index(snapshots.size()));
  for_each_block(motion, [&](int64_t, const Matrix& D) {
    C.noalias() += D * chosen_rows(D, snapshots).transpose();
  });
  return C;
}

/// A row of vertices (x, y, z, ...) times a 3x3 matrix, rounded to float32.
Eigen::RowVectorXf in_mesh_numbers(const Matrix3& to_mesh, const Eigen::RowVectorXd& d) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> A(to_mesh.data());
  Eigen::RowVectorXf result(d.size());
  for (Eigen::Index i = 0; i < d.size(); i += 3) {
    result.segment<3>(i) = (A * d.segment<3>(i).transpose()).transpose().cast<float>();
  }
  return result;
}

Eigen::RowVectorXd in_metres(const Matrix3& to_metres, const Eigen::RowVectorXf& d) {
  const Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>> A(to_metres.data());
  Eigen::RowVectorXd result(d.size());
  for (Eigen::Index i = 0; i < d.size(); i += 3) {
    result.segment<3>(i) = (A * d.segment<3>(i).cast<double>().transpose()).transpose();
  }
  return result;
}

/// Largest length of the vertices in the rows of R, squared.
double largest_square(const Matrix& R) {
  double largest = 0;
  const double* r = R.data();
  for (Eigen::Index i = 0; i < R.size(); i += 3) {
    largest = std::max(largest, r[i] * r[i] + r[i + 1] * r[i + 1] + r[i + 2] * r[i + 2]);
  }
  return largest;
}

/// Largest error with the first 0, 1, ..., modes modes [m].
std::vector<double> errors(const Motion& motion, const ModalBasis& basis) {
  std::vector<double> worst(size_t(basis.modes()) + 1, 0);
  for_each_block(motion, [&](int64_t, Matrix& R) {
    const Matrix modes = modes_of(R, basis);
    worst[0] = std::max(worst[0], largest_square(R));
    for (int k = 0; k < basis.modes(); ++k) {
      const Eigen::RowVectorXd mode =
          in_metres(motion.to_metres, in_mesh_numbers(motion.to_mesh, modes.row(k)));
      for (int64_t t = 0; t < motion.frames; ++t) R.row(t) -= double(basis.weights(t, k)) * mode;
      worst[size_t(k) + 1] = std::max(worst[size_t(k) + 1], largest_square(R));
    }
  });
  for (double& e : worst) e = std::sqrt(e);
  return worst;
}

/// Columns 0, ..., modes - 1 of an array.
template <class T>
Array<T> first_columns(const Array<T>& from, int modes) {
  Array<T> result(from.rows(), modes);
  for (int64_t r = 0; r < from.rows(); ++r) std::copy_n(from.row(r), modes, result.row(r));
  return result;
}

/// All modes that double precision can tell from noise, largest first, at most 64:
/// G v_k = lambda_k v_k, weights_k = C v_k / lambda_k, then each scaled to a largest weight of 1.
ModalBasis principal_modes(const Matrix& C, const std::vector<int64_t>& moving,
                           std::vector<int64_t> snapshots) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(chosen_rows(C, snapshots));
  const auto n = Eigen::Index(snapshots.size());
  const double noise = 1e-15 * double(n) * eigen.eigenvalues()(n - 1);
  int modes = 0;
  while (modes < std::min<Eigen::Index>(n, kMaxModes) && eigen.eigenvalues()(n - 1 - modes) > noise)
    ++modes;
  ModalBasis basis{Array<float>(C.rows(), modes), std::move(snapshots), Array<double>(n, modes), 0};
  for (int k = 0; k < modes; ++k) {
    const Eigen::VectorXd v = eigen.eigenvectors().col(n - 1 - k);
    const Eigen::VectorXd weight = C * v / eigen.eigenvalues()(n - 1 - k);
    const double scale = weight.cwiseAbs().maxCoeff();
    for (const int64_t t : moving) basis.weights(t, k) = float(weight(t) / scale);
    for (Eigen::Index s = 0; s < n; ++s) basis.shares(s, k) = v(s) * scale;
  }
  return basis;
}

}  // namespace

ModalBasis modal_basis(const Motion& motion, double tolerance) {
  const std::vector<int64_t> moving = moving_frames(motion);
  if (moving.empty()) return {Array<float>(motion.frames, 0), {}, Array<double>(0, 0), 0};
  std::vector<int64_t> snapshots = chosen_snapshots(moving);
  const Matrix C = inner_products(motion, snapshots);
  ModalBasis basis = principal_modes(C, moving, std::move(snapshots));

  // the fewest modes that are good enough, or the best
  const std::vector<double> error = errors(motion, basis);
  const auto enough =
      std::find_if(error.begin(), error.end(), [&](double e) { return e <= tolerance; });
  const auto best = enough != error.end() ? enough : std::min_element(error.begin(), error.end());
  const int modes = int(best - error.begin());
  basis.weights = first_columns(basis.weights, modes);
  basis.shares = first_columns(basis.shares, modes);
  basis.max_error = *best;
  return basis;
}

ModalBasis keyframe_basis(const Motion& motion) {
  ModalBasis basis;
  basis.snapshots = moving_frames(motion);
  const auto modes = int(basis.snapshots.size());
  basis.weights = Array<float>(motion.frames, modes);
  for (int k = 0; k < modes; ++k) basis.weights(basis.snapshots[size_t(k)], k) = 1;

  // what rounding in the numbers of the mesh leaves
  std::vector<float> d(size_t(3 * motion.vertices));
  for (const int64_t t : basis.snapshots) {
    motion.read(t, 0, motion.vertices, d.data());
    const Eigen::RowVectorXd exact =
        Eigen::Map<const Eigen::RowVectorXf>(d.data(), 3 * motion.vertices).cast<double>();
    const Matrix rest = exact - in_metres(motion.to_metres, in_mesh_numbers(motion.to_mesh, exact));
    basis.max_error = std::max(basis.max_error, std::sqrt(largest_square(rest)));
  }
  return basis;
}

Array<float> mode_shapes(const Motion& motion, const ModalBasis& basis) {
  Array<float> shapes(basis.modes(), int(3 * motion.vertices));
  for_each_block(motion, [&](int64_t first, const Matrix& D) {
    const Matrix modes = modes_of(D, basis);
    for (int k = 0; k < basis.modes(); ++k) {
      const Eigen::RowVectorXf mode = in_mesh_numbers(motion.to_mesh, modes.row(k));
      std::copy_n(mode.data(), mode.size(), shapes.row(k) + 3 * first);
    }
  });
  return shapes;
}

}  // namespace elastogen
