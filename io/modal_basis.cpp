// SPDX-License-Identifier: Apache-2.0
#include "io/modal_basis.hpp"

#include "core/error.hpp"

#include <Eigen/Dense>

#include <algorithm>
#include <cmath>
#include <optional>

namespace elastogen {

namespace {

using Matrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
using Row = Eigen::RowVectorXd;
using Map3 = Eigen::Map<const Eigen::Matrix<double, 3, 3, Eigen::RowMajor>>;

/// Vertices that are held in memory at once, for all frames.
int64_t block_size(int64_t frames) {
  return std::clamp<int64_t>((int64_t{1} << 21) / std::max<int64_t>(frames, 1), 64, 1 << 16);
}

/// Displacements of `count` vertices in the given frames [m], (frames, 3 count).
Matrix read_rows(const Motion& motion, const std::vector<int64_t>& frames, int64_t first,
                 int64_t count) {
  Matrix D(frames.size(), 3 * count);
  std::vector<float> row(size_t(3 * count));
  for (size_t t = 0; t < frames.size(); ++t) {
    motion.read(frames[t], first, count, row.data());
    D.row(Eigen::Index(t)) =
        Eigen::Map<const Eigen::RowVectorXf>(row.data(), 3 * count).cast<double>();
  }
  return D;
}

/// Calls f(part, first, D) for blocks of vertices; row t of D is frames[t] [m].
template <class F>
void for_each_block(const Motion& motion, const std::vector<int64_t>& frames, const F& f) {
  const int64_t size = block_size(int64_t(frames.size()));
  for (const MotionPart& part : motion.parts)
    for (int64_t first = 0; first < part.vertices; first += size) {
      const int64_t count = std::min(size, part.vertices - first);
      Matrix D = read_rows(motion, frames, part.first + first, count);
      f(part, first, D);
    }
}

std::vector<int64_t> frames_of(const FrameRange& range) {
  std::vector<int64_t> frames;
  for (int64_t t = range.first; t <= range.last; ++t) frames.push_back(t);
  return frames;
}

/// At most 256 of the frames, evenly spaced, the last one included.
std::vector<int64_t> chosen_snapshots(const std::vector<int64_t>& moving) {
  const auto n = int64_t(moving.size()), count = std::min<int64_t>(n, kMaxSnapshots);
  std::vector<int64_t> snapshots;
  for (int64_t s = 1; s <= count; ++s) snapshots.push_back(moving[size_t(s * n / count - 1)]);
  return snapshots;
}

/// Rows of D for some of the frames; D has one row for each of `frames`, and both lists ascend.
Matrix chosen_rows(const Matrix& D, const std::vector<int64_t>& frames,
                   const std::vector<int64_t>& chosen) {
  Matrix result(chosen.size(), D.cols());
  for (size_t r = 0, t = 0; r < chosen.size(); ++r, ++t) {
    while (frames[t] != chosen[r]) ++t;
    result.row(Eigen::Index(r)) = D.row(Eigen::Index(t));
  }
  return result;
}

/// A row of vertices (x, y, z, ...), each times a 3x3 matrix.
Row mapped(const Matrix3& matrix, const Row& d) {
  const Map3 A(matrix.data());
  Row result(d.size());
  for (Eigen::Index i = 0; i < d.size(); i += 3)
    result.segment<3>(i) = (A * d.segment<3>(i).transpose()).transpose();
  return result;
}

/// The part of a displacement that a mesh can show: not all of it if its node is scaled to zero.
Row shown(const MotionPart& part, const Row& d) {
  return mapped(part.to_metres, mapped(part.to_mesh, d));
}

/// The part of a target that a mesh shows after storage in float32.
Row shown_as_stored(const MotionPart& part, const Row& target) {
  const Eigen::RowVectorXf stored = mapped(part.to_mesh, target).cast<float>();
  return mapped(part.to_metres, stored.cast<double>());
}

/// Largest length of the vertices in the rows of R, squared.
double largest_square(const Matrix& R) {
  double largest = 0;
  const double* r = R.data();
  for (Eigen::Index i = 0; i < R.size(); i += 3)
    largest = std::max(largest, r[i] * r[i] + r[i + 1] * r[i + 1] + r[i + 2] * r[i + 2]);
  return largest;
}

/// The moving frames d_t = c_t m_0 + sum_k w_tk m_k with modes m_k = sum_s shares_sk d_s, c_t > 0.
struct PrincipalModes {
  std::vector<int64_t> snapshots;
  Matrix weights;  ///< column 0 is the carrier c, 1 at most, then w; (moving frames, 1 + modes)
  Matrix shares;   ///< (snapshots, 1 + modes)

  int modes() const { return int(weights.cols()) - 1; }
};

/// Inner products of the moving frames with the snapshots [m^2], (moving, snapshots).
Matrix inner_products(const Motion& motion, const std::vector<int64_t>& moving,
                      const std::vector<int64_t>& snapshots) {
  Matrix C = Matrix::Zero(Eigen::Index(moving.size()), Eigen::Index(snapshots.size()));
  for_each_block(motion, moving, [&](const MotionPart&, int64_t, const Matrix& D) {
    C.noalias() += D * chosen_rows(D, moving, snapshots).transpose();
  });
  return C;
}

using Eigensystem = Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>;

/// How many of the largest modes double precision can tell from noise, at most `most`.
int clear_modes(const Eigensystem& eigen, double largest_square, int most) {
  const Eigen::Index n = eigen.eigenvalues().size();
  const double noise = 1e-15 * double(n) * largest_square;
  int modes = 0;
  while (modes < std::min<Eigen::Index>(n, most) && eigen.eigenvalues()(n - 1 - modes) > noise)
    ++modes;
  return modes;
}

/// Modes about the mean, which every frame has in full: H G H v_k = lambda_k v_k with the inner
/// products G of the snapshots and H = 1 - 1/n, w_tk = (d_t - mean) . m_k / lambda_k.
PrincipalModes about_mean(const Matrix& C, const std::vector<int64_t>& moving,
                          std::vector<int64_t> snapshots, int most) {
  const auto n = Eigen::Index(snapshots.size());
  const Matrix G = chosen_rows(C, moving, snapshots);
  const Row column_mean = G.colwise().mean();
  Eigen::MatrixXd centred = G.rowwise() - column_mean;
  centred.colwise() -= centred.rowwise().mean().eval();
  const Eigensystem eigen(centred);
  const int modes = clear_modes(eigen, G.diagonal().maxCoeff(), std::min<int>(most, int(n) - 1));
  PrincipalModes result{std::move(snapshots), Matrix(C.rows(), modes + 1), Matrix(n, modes + 1)};
  result.weights.col(0).setOnes();
  result.shares.col(0).setConstant(1 / double(n));
  for (int k = 0; k < modes; ++k) {
    const Eigen::VectorXd v = eigen.eigenvectors().col(n - 1 - k);
    result.shares.col(k + 1) = v;
    result.weights.col(k + 1) =
        ((C * v).array() - column_mean.dot(v)) / eigen.eigenvalues()(n - 1 - k);
  }
  return result;
}

/// Modes about the rest pose with the first mode as carrier; no value if that changes sign:
/// G v_k = lambda_k v_k, w_tk = d_t . m_k / lambda_k.
std::optional<PrincipalModes> about_rest(const Matrix& C, const std::vector<int64_t>& moving,
                                         std::vector<int64_t> snapshots, int most) {
  const auto n = Eigen::Index(snapshots.size());
  const Matrix G = chosen_rows(C, moving, snapshots);
  const Eigensystem eigen(G);
  const int columns = clear_modes(eigen, G.diagonal().maxCoeff(), most + 1);
  PrincipalModes result{std::move(snapshots), Matrix(C.rows(), columns), Matrix(n, columns)};
  for (int k = 0; k < columns; ++k) {
    const Eigen::VectorXd v = eigen.eigenvectors().col(n - 1 - k);
    result.shares.col(k) = v;
    result.weights.col(k) = C * v / eigen.eigenvalues()(n - 1 - k);
  }
  if (columns == 0) return {};
  // the carrier is positive, 1 at most
  const double first = result.weights(0, 0);
  const double scale = std::copysign(result.weights.col(0).cwiseAbs().maxCoeff(), first);
  result.weights.col(0) /= scale;
  result.shares.col(0) *= scale;
  if (!(result.weights.col(0).minCoeff() > 0)) return {};
  return result;
}

/// Largest errors with the carrier and the first 0, 1, ... modes [m].
std::vector<double> errors(const Motion& motion, const std::vector<int64_t>& moving,
                           const PrincipalModes& modes) {
  std::vector<double> worst(size_t(modes.modes()) + 1, 0);
  for_each_block(motion, moving, [&](const MotionPart& part, int64_t, Matrix& R) {
    const Matrix S = chosen_rows(R, moving, modes.snapshots);
    for (int k = 0; k <= modes.modes(); ++k) {
      const Row mode = shown(part, modes.shares.col(k).transpose() * S);
      for (Eigen::Index t = 0; t < R.rows(); ++t) R.row(t) -= modes.weights(t, k) * mode;
      worst[size_t(k)] = std::max(worst[size_t(k)], largest_square(R));
    }
  });
  for (double& e : worst) e = std::sqrt(e);
  return worst;
}

/// The basis of the carrier and the first modes, with weights stretched to 0 ... 1.
ModalBasis stretched(const PrincipalModes& from, const FrameRange& range,
                     const std::vector<int64_t>& moving, int modes) {
  const auto n = int64_t(from.snapshots.size());
  const Eigen::ArrayXd carrier = from.weights.col(0);
  ModalBasis basis{Array<float>(range.count(), modes + 1), from.snapshots,
                   Array<double>(n, modes + 1), 0};
  for (int64_t s = 0; s < n; ++s) basis.shares(s, 0) = from.shares(s, 0);
  for (size_t t = 0; t < moving.size(); ++t)
    basis.weights(moving[t] - range.first, 0) = float(carrier(Eigen::Index(t)));
  for (int k = 1; k <= modes; ++k) {
    const double lo = (from.weights.col(k).array() / carrier).minCoeff();
    const Eigen::ArrayXd above = from.weights.col(k).array() - lo * carrier;
    const double range_of_mode = std::max(above.maxCoeff(), 1e-300);
    for (int64_t s = 0; s < n; ++s) {
      basis.shares(s, 0) += lo * from.shares(s, k);
      basis.shares(s, k) = range_of_mode * from.shares(s, k);
    }
    for (size_t t = 0; t < moving.size(); ++t)
      basis.weights(moving[t] - range.first, k) =
          float(std::clamp(above(Eigen::Index(t)) / range_of_mode, 0.0, 1.0));
  }
  return basis;
}

/// Targets of a block of vertices from their snapshots S [m], (targets, 3 vertices).
Matrix targets_of(const Matrix& S, const ModalBasis& basis) {
  if (basis.shares.empty()) return S;
  const Eigen::Map<const Matrix> shares(basis.shares.data(), basis.shares.rows(), basis.targets());
  return shares.transpose() * S;
}

/// Largest error after storage, over all frames of the range [m].
double stored_error(const Motion& motion, const FrameRange& range, const ModalBasis& basis) {
  const std::vector<int64_t> frames = frames_of(range);
  double worst = 0;
  for_each_block(motion, frames, [&](const MotionPart& part, int64_t, Matrix& R) {
    const Matrix targets = targets_of(chosen_rows(R, frames, basis.snapshots), basis);
    for (int k = 0; k < basis.targets(); ++k) {
      const Row target = shown_as_stored(part, targets.row(k));
      for (Eigen::Index t = 0; t < R.rows(); ++t) {
        const double weight = basis.weights(t, k);
        if (weight != 0) R.row(t) -= weight * target;
      }
    }
    worst = std::max(worst, largest_square(R));
  });
  return std::sqrt(worst);
}

/// With fewer targets than this a basis with one less is tried.
constexpr int kFew = 12;

/// The fewest modes that are good enough, else the best number of modes.
ModalBasis fewest(const Motion& motion, const FrameRange& frames,
                  const std::vector<int64_t>& moving, const PrincipalModes& modes,
                  double tolerance) {
  const std::vector<double> error = errors(motion, moving, modes);
  const auto enough =
      std::find_if(error.begin(), error.end(), [&](double e) { return e <= tolerance; });
  const auto best = enough != error.end() ? enough : std::min_element(error.begin(), error.end());
  for (int count = int(best - error.begin());; ++count) {
    ModalBasis basis = stretched(modes, frames, moving, count);
    basis.max_error = stored_error(motion, frames, basis);
    // rounding may add a little to the error of the modes themselves
    const bool may_gain = enough != error.end() && count < modes.modes();
    if (basis.max_error <= tolerance || !may_gain) return basis;
  }
}

}  // namespace

std::vector<int64_t> moving_frames(const Motion& motion, const FrameRange& range) {
  const std::vector<int64_t> frames = frames_of(range);
  std::vector<char> moves(frames.size(), 0);
  for_each_block(motion, frames, [&](const MotionPart&, int64_t, const Matrix& D) {
    for (size_t t = 0; t < frames.size(); ++t) moves[t] |= !D.row(Eigen::Index(t)).isZero(0);
  });
  std::vector<int64_t> moving;
  for (size_t t = 0; t < frames.size(); ++t)
    if (moves[t]) moving.push_back(frames[t]);
  return moving;
}

double unshown_error(const Motion& motion, const FrameRange& frames) {
  double worst = 0;
  for_each_block(motion, frames_of(frames), [&](const MotionPart& part, int64_t, Matrix& D) {
    for (Eigen::Index t = 0; t < D.rows(); ++t) D.row(t) -= shown(part, D.row(t));
    worst = std::max(worst, largest_square(D));
  });
  return std::sqrt(worst);
}

ModalBasis modal_basis(const Motion& motion, const FrameRange& frames, double tolerance,
                       int max_targets) {
  ELASTOGEN_CHECK(max_targets > 0, "max_targets must be positive, got ", max_targets);
  const std::vector<int64_t> moving = moving_frames(motion, frames);
  if (moving.empty()) return {Array<float>(frames.count(), 0), {}, Array<double>(0, 0), 0};
  const std::vector<int64_t> snapshots = chosen_snapshots(moving);
  const Matrix C = inner_products(motion, moving, snapshots);
  ModalBasis best =
      fewest(motion, frames, moving, about_mean(C, moving, snapshots, max_targets - 1), tolerance);
  // the mean is one target beside the modes; with few modes leaving it out saves size
  const int fewer = best.targets() - 1;
  if (best.max_error > tolerance || fewer < 1 || fewer > kFew) return best;
  const auto carried = about_rest(C, moving, snapshots, fewer - 1);
  if (!carried) return best;
  ModalBasis other = fewest(motion, frames, moving, *carried, tolerance);
  return other.max_error <= tolerance ? other : best;
}

ModalBasis keyframe_basis(const Motion& motion, const FrameRange& frames) {
  ModalBasis basis;
  basis.snapshots = moving_frames(motion, frames);
  const auto targets = int(basis.snapshots.size());
  basis.weights = Array<float>(frames.count(), targets);
  for (int k = 0; k < targets; ++k) basis.weights(basis.snapshots[size_t(k)] - frames.first, k) = 1;
  basis.max_error = stored_error(motion, frames, basis);
  return basis;
}

Array<float> target_shapes(const Motion& motion, const MotionPart& part, const ModalBasis& basis) {
  Array<float> shapes(basis.targets(), int(3 * part.vertices));
  const Motion alone{{part}, motion.read};
  for_each_block(alone, basis.snapshots, [&](const MotionPart&, int64_t first, const Matrix& S) {
    const Matrix targets = targets_of(S, basis);
    for (int k = 0; k < basis.targets(); ++k) {
      const Eigen::RowVectorXf target = mapped(part.to_mesh, targets.row(k)).cast<float>();
      std::copy_n(target.data(), target.size(), shapes.row(k) + 3 * first);
    }
  });
  return shapes;
}

}  // namespace elastogen
