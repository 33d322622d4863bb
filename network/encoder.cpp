// SPDX-License-Identifier: Apache-2.0
#include "network/encoder.hpp"

#include "network/smooth_modes.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int kSmallestPiece = 64;  // nodes; multigrid alone serves smaller ones
constexpr size_t kMostPieces = 64;
constexpr int kCosines = 18;

}  // namespace

template <class T>
Encoder<T>::Encoder(IncrementalPotential& potential) {
  find_pieces(potential.scene());
  for (Piece& piece : pieces_) fill_modes(potential.scene(), piece);
  build_operators(potential);
}

/// The largest pieces, by node count; ties by number.
template <class T>
void Encoder<T>::find_pieces(const Scene& scene) {
  const VoxelGrid& grid = scene.grid;
  std::vector<std::vector<int32_t>> nodes(size_t(grid.pieces));
  for (int64_t n = 0; n < grid.node_count(); ++n)
    nodes[size_t(grid.piece(n))].push_back(int32_t(n));
  std::stable_sort(nodes.begin(), nodes.end(),
                   [](const auto& a, const auto& b) { return a.size() > b.size(); });
  for (std::vector<int32_t>& list : nodes) {
    if (list.size() < kSmallestPiece || pieces_.size() == kMostPieces) break;
    pieces_.emplace_back().nodes = std::move(list);
  }
}

template <class T>
void Encoder<T>::fill_modes(const Scene& scene, Piece& piece) {
  Box box;
  bool pinned = false;
  for (const int32_t n : piece.nodes) {
    box.add({scene.grid.rest(n, 0), scene.grid.rest(n, 1), scene.grid.rest(n, 2)});
    pinned |= scene.pinned(n) != 0;
  }
  const double size = std::max({box.extent(0), box.extent(1), box.extent(2)});
  const std::vector<Wave> waves = lowest_waves(box, kCosines);
  std::vector<double> distance;
  if (pinned) distance = pin_distance(scene, piece.nodes);
  piece.modes.resize(piece.nodes.size() * kModes);
  for_each(int64_t(piece.nodes.size()), [&](int64_t k) {
    const double* X = scene.grid.rest.row(piece.nodes[size_t(k)]);
    const double d = pinned ? distance[size_t(k)] : 0;
    const double factor = pinned ? d / (d + size / 8) : 1;
    T* mode = piece.modes.data() + k * kModes;
    for (int w = 0; w < kCosines; ++w) mode[w] = T(factor * cosine(waves[size_t(w)], box, X));
    for (int i = 0; i < 3; ++i)
      mode[kCosines + i] =
          T(factor * (2 * X[i] - box.lower[size_t(i)] - box.upper[size_t(i)]) / size);
  });
}

/// sums = B^T p of one piece in float64.
template <class T>
void Encoder<T>::project(const Piece& piece, const double* p, double sums[]) {
  constexpr int64_t kChunk = 1024, kSize = 3 * kModes;
  const int64_t n = int64_t(piece.nodes.size());
  std::vector<double> partial(size_t((n + kChunk - 1) / kChunk * kSize));
  for_blocks(
      n,
      [&](int64_t begin, int64_t end) {
        double* sum = partial.data() + begin / kChunk * kSize;
        for (int64_t k = begin; k < end; ++k) {
          const T* mode = piece.modes.data() + k * kModes;
          const double* value = p + 3 * int64_t(piece.nodes[size_t(k)]);
          for (int i = 0; i < 3; ++i)
            for (int m = 0; m < kModes; ++m) sum[i * kModes + m] += double(mode[m]) * value[i];
        }
      },
      kChunk);
  std::fill(sums, sums + kSize, 0);
  for (size_t c = 0; c < partial.size(); c += kSize)
    for (int i = 0; i < 3; ++i)
      for (int m = 0; m < kModes; ++m) sums[3 * m + i] += partial[c + size_t(i * kModes + m)];
}

/// A_r of all pieces at once: they do not touch, so one product serves a mode of each.
template <class T>
void Encoder<T>::build_operators(IncrementalPotential& potential) {
  constexpr int kSize = 3 * kModes;
  using Matrix = Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>;
  const size_t nodes = size_t(potential.scene().grid.node_count());
  std::vector<Matrix, Eigen::aligned_allocator<Matrix>> A(pieces_.size());
  std::vector<double> p(3 * nodes), Ap(3 * nodes);
  reduced_.resize(pieces_.size() * kSize);
  solution_.resize(reduced_.size());
  for (int column = 0; column < kSize; ++column) {
    const int mode = column / 3, component = column % 3;
    std::fill(p.begin(), p.end(), 0);
    for (const Piece& piece : pieces_)
      for (size_t k = 0; k < piece.nodes.size(); ++k)
        p[3 * size_t(piece.nodes[k]) + size_t(component)] =
            double(piece.modes[k * kModes + size_t(mode)]);
    potential.rest_hessian_product(p.data(), Ap.data());
    for (size_t s = 0; s < pieces_.size(); ++s) {
      double sums[kSize];
      project(pieces_[s], Ap.data(), sums);
      for (int row = 0; row < kSize; ++row) A[s](row, column) = sums[row];
    }
  }
  place_.assign(nodes, {-1, -1});
  for (size_t s = 0; s < pieces_.size(); ++s) {
    pieces_[s].rest.assign(A[s].data(), A[s].data() + kSize * kSize);
    invert(pieces_[s], pieces_[s].rest);
    for (size_t k = 0; k < pieces_[s].nodes.size(); ++k)
      place_[size_t(pieces_[s].nodes[k])] = {int32_t(s), int32_t(k)};
  }
}

/// Inverse of A scaled to unit diagonal; 1e-9 keeps directions that the modes hold twice harmless.
template <class T>
void Encoder<T>::invert(Piece& piece, const std::vector<double>& A) {
  constexpr int kSize = 3 * kModes;
  using Matrix = Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>;
  const Eigen::Map<const Matrix> full(A.data());
  const Eigen::Matrix<double, kSize, 1> scale =
      full.diagonal().array().max(1e-300).sqrt().inverse().matrix();
  Matrix scaled = scale.asDiagonal() * (full + full.transpose()) * scale.asDiagonal() / 2;
  scaled.diagonal().array() += 1e-9;
  const Matrix inverse = scaled.llt().solve(Matrix::Identity());
  const Matrix result =
      scale.asDiagonal() * (inverse + inverse.transpose()) * scale.asDiagonal() / 2;
  piece.inverse.assign(result.data(), result.data() + kSize * kSize);
}

template <class T>
void Encoder<T>::set_nodal_stiffness(const std::vector<int32_t>& nodes,
                                     const std::vector<double>& blocks) {
  constexpr size_t kSize = 3 * kModes;
  std::vector<std::vector<double>> A(pieces_.size());
  for (size_t s = 0; s < nodes.size(); ++s) {
    const auto [piece, local] = place_[size_t(nodes[s])];
    if (piece < 0) continue;
    std::vector<double>& sum = A[size_t(piece)];
    if (sum.empty()) sum = pieces_[size_t(piece)].rest;
    const T* mode = pieces_[size_t(piece)].modes.data() + size_t(local) * kModes;
    for (size_t m = 0; m < kModes; ++m)
      for (size_t i = 0; i < 3; ++i) {
        double* row = sum.data() + (3 * m + i) * kSize;
        for (size_t n = 0; n < kModes; ++n)
          for (size_t j = 0; j < 3; ++j)
            row[3 * n + j] += double(mode[m]) * double(mode[n]) * blocks[9 * s + 3 * i + j];
      }
  }
  for (size_t p = 0; p < pieces_.size(); ++p)
    invert(pieces_[p], A[p].empty() ? pieces_[p].rest : A[p]);
}

template <class T>
void Encoder<T>::encode(const T* r, double* y) const {
  constexpr int64_t kChunk = 1024;
  constexpr int kSize = 3 * kModes;
  for (size_t s = 0; s < pieces_.size(); ++s) {
    const Piece& piece = pieces_[s];
    const int64_t n = int64_t(piece.nodes.size()), chunks = (n + kChunk - 1) / kChunk;
    std::vector<T> partial(size_t(chunks) * kSize);
    for_blocks(
        n,
        [&](int64_t begin, int64_t end) {
          T* sum = partial.data() + begin / kChunk * kSize;
          for (int64_t k = begin; k < end; ++k) {
            const T* mode = piece.modes.data() + k * kModes;
            const T* value = r + 3 * int64_t(piece.nodes[size_t(k)]);
            for (int i = 0; i < 3; ++i)
              for (int m = 0; m < kModes; ++m) sum[i * kModes + m] += mode[m] * value[i];
          }
        },
        kChunk);
    double* result = y + s * kSize;
    std::fill(result, result + kSize, 0);
    for (int64_t c = 0; c < chunks; ++c)
      for (int i = 0; i < 3; ++i)
        for (int m = 0; m < kModes; ++m)
          result[3 * m + i] += double(partial[size_t(c * kSize + i * kModes + m)]);
  }
}

template <class T>
void Encoder<T>::decode(const double* y, T* z) const {
  constexpr int kSize = 3 * kModes;
  for (size_t s = 0; s < pieces_.size(); ++s) {
    const Piece& piece = pieces_[s];
    T coefficient[3][kModes];
    for (int i = 0; i < 3; ++i)
      for (int m = 0; m < kModes; ++m) coefficient[i][m] = T(y[s * kSize + size_t(3 * m + i)]);
    for_each(int64_t(piece.nodes.size()), [&](int64_t k) {
      const T* mode = piece.modes.data() + k * kModes;
      T* value = z + 3 * int64_t(piece.nodes[size_t(k)]);
      for (int i = 0; i < 3; ++i) {
        T sum = 0;
        for (int m = 0; m < kModes; ++m) sum += mode[m] * coefficient[i][m];
        value[i] += sum;
      }
    });
  }
}

template <class T>
void Encoder<T>::add(const T* r, T* z) {
  constexpr int kSize = 3 * kModes;
  encode(r, reduced_.data());
  for (size_t s = 0; s < pieces_.size(); ++s) {
    using Vector = Eigen::Matrix<double, kSize, 1>;
    using Matrix = Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>;
    const Eigen::Map<const Matrix> inverse(pieces_[s].inverse.data());
    Eigen::Map<Vector>(solution_.data() + s * kSize).noalias() =
        inverse * Eigen::Map<const Vector>(reduced_.data() + s * kSize);
  }
  decode(solution_.data(), z);
}

template class Encoder<float>;
template class Encoder<double>;

}  // namespace elastogen
