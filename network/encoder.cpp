// SPDX-License-Identifier: Apache-2.0
#include "network/encoder.hpp"

#include "network/encoder_operator.hpp"
#include "network/smooth_modes.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

constexpr int kSmallestPiece = 64;  // nodes; multigrid alone serves smaller ones
constexpr size_t kMostPieces = 64;
constexpr int kCosines = 18;

/// A mode's value to the digits that are kept of it: in float those of half precision, in which a
/// card holds it. All uses of a mode agree in them, so that it is as good a mode as before.
float kept(double mode, float) {
  // Veltkamp's splitting: the 11 leading bits
  const float x = float(mode), c = x * 8193;
  return c - (c - x);
}
double kept(double mode, double) {
  return mode;
}

constexpr int kSize = 3 * Encoder<float>::kModes;
using Reduced = Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>;
using ReducedVector = Eigen::Matrix<double, kSize, 1>;

/// The entries of a reduced operator that couple a component with itself; the others 0.
Reduced within_components(const Reduced& A) {
  Reduced D = A;
  for (int a = 0; a < kSize; ++a)
    for (int b = 0; b < kSize; ++b)
      if (a % 3 != b % 3) D(a, b) = 0;
  return D;
}

/// Box of some nodes at rest.
Box rest_box(const Scene& scene, const std::vector<int32_t>& nodes) {
  std::vector<Box> boxes((nodes.size() + size_t(kBlock) - 1) / size_t(kBlock));
  for_each(int64_t(nodes.size()), [&](int64_t k) {
    const double* X = scene.grid.rest.row(nodes[size_t(k)]);
    boxes[size_t(k / kBlock)].add({X[0], X[1], X[2]});
  });
  Box box;
  for (const Box& part : boxes) {
    box.add(part.lower);
    box.add(part.upper);
  }
  return box;
}

}  // namespace

template <class T>
Encoder<T>::Encoder(const IncrementalPotential& potential, const MakeOperators& make) {
  build_modes(potential.scene());
  make_operators(potential, make);
}

template <class T>
std::optional<Encoder<T>> Encoder<T>::if_soft(const IncrementalPotential& potential, double least,
                                              const MakeOperators& make) {
  constexpr int64_t kSample = 1 << 16, kSparsest = 16;  // voxels; of that many blocks one
  const int64_t voxels = potential.scene().grid.voxel_count();
  const int64_t stride = std::clamp<int64_t>(voxels / kSample, 1, kSparsest);
  Encoder encoder;
  encoder.build_modes(potential.scene());
  if (stride > 1 && !make) {
    encoder.take_operators(encoder.rest_operators(potential, stride));
    if (encoder.softness() < least) return {};
  }
  encoder.make_operators(potential, make);
  if (encoder.softness() < least) return {};
  return encoder;
}

template <class T>
void Encoder<T>::make_operators(const IncrementalPotential& potential, const MakeOperators& make) {
  take_operators(make ? make(*this) : rest_operators(potential, 1));
}

template <class T>
void Encoder<T>::build_modes(const Scene& scene) {
  find_pieces(scene);
  for (Piece& piece : pieces_) fill_modes(scene, piece);
}

/// The largest pieces, by node count; ties by number.
template <class T>
void Encoder<T>::find_pieces(const Scene& scene) {
  const VoxelGrid& grid = scene.grid;
  std::vector<int32_t> size(size_t(grid.pieces)), order(size.size()), rank(size.size(), -1);
  for (int64_t n = 0; n < grid.node_count(); ++n) ++size[size_t(grid.piece(n))];
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](int32_t a, int32_t b) { return size[size_t(a)] > size[size_t(b)]; });
  size_t count = 0;
  while (count < std::min(order.size(), kMostPieces) &&
         size[size_t(order[count])] >= kSmallestPiece)
    ++count;
  for (size_t s = 0; s < count; ++s) rank[size_t(order[s])] = int32_t(s);
  std::vector<std::vector<int32_t>> nodes =
      grouped(grid.node_count(), count, [&](int64_t n) { return rank[size_t(grid.piece(n))]; });
  place_.resize(size_t(grid.node_count()));
  for_each(grid.node_count(), [&](int64_t n) {
    place_[size_t(n)] = {rank[size_t(grid.piece(n))], -1};
  });
  for (std::vector<int32_t>& list : nodes) {
    for_each(int64_t(list.size()),
             [&](int64_t k) { place_[size_t(list[size_t(k)])].local = int32_t(k); });
    pieces_.emplace_back().nodes = std::move(list);
  }
}

template <class T>
void Encoder<T>::fill_modes(const Scene& scene, Piece& piece) {
  const Box box = rest_box(scene, piece.nodes);
  const double size = std::max({box.extent(0), box.extent(1), box.extent(2)});
  const PlaneCosines cosines(scene.grid, piece.nodes, lowest_waves(box, kCosines), box);
  const Zeroed<double> distance = pin_distance(scene, piece.nodes);
  piece.modes.resize((piece.nodes.size() - 1) * kModes + kPacks * kLanes);
  for_each(int64_t(piece.nodes.size()), [&](int64_t k) {
    const double* X = scene.grid.rest.row(piece.nodes[size_t(k)]);
    const double d = distance[size_t(k)], factor = d / (d + size / 8);
    T* mode = piece.modes.data() + k * kModes;
    for (int w = 0; w < kCosines; ++w)
      mode[w] = kept(factor * cosines(w, scene.grid.node_coord.row(piece.nodes[size_t(k)])), T{});
    for (int i = 0; i < 3; ++i)
      mode[kCosines + i] =
          kept(factor * (2 * X[i] - box.lower[size_t(i)] - box.upper[size_t(i)]) / size, T{});
  });
}

/// A_r of the pieces at rest, by stride as in reduced_rest_operator.
template <class T>
std::vector<std::vector<double>> Encoder<T>::rest_operators(const IncrementalPotential& potential,
                                                            int64_t stride) const {
  const VoxelGrid& grid = potential.scene().grid;
  const std::vector<std::vector<int32_t>> voxels =
      grouped(grid.voxel_count(), pieces_.size(),
              [&](int64_t v) { return place_[size_t(grid.corners(v, 0))].piece; });
  std::vector<std::vector<double>> operators;
  for (size_t s = 0; s < pieces_.size(); ++s)
    operators.push_back(reduced_rest_operator<T>(
        potential, {pieces_[s].nodes, place_, voxels[s], pieces_[s].modes}, stride));
  return operators;
}

template <class T>
void Encoder<T>::take_operators(std::vector<std::vector<double>>&& operators) {
  for (size_t s = 0; s < pieces_.size(); ++s) {
    pieces_[s].rest = std::move(operators[s]);
    invert(pieces_[s], pieces_[s].rest);
  }
  reduced_.resize(pieces_.size() * 3 * kModes);
  solution_.resize(reduced_.size());
}

/// Of A scaled to unit diagonal; 1e-9 keeps directions that the modes hold twice harmless.
template <class T>
void Encoder<T>::invert(Piece& piece, const std::vector<double>& A) {
  const Eigen::Map<const Reduced> full(A.data());
  const ReducedVector scale = full.diagonal().array().max(1e-300).sqrt().inverse().matrix();
  Reduced scaled = scale.asDiagonal() * (full + full.transpose()) * scale.asDiagonal() / 2;
  scaled.diagonal().array() += 1e-9;
  const auto take_inverse = [&](const Reduced& of) {
    const Reduced inverse = of.llt().solve(Reduced::Identity());
    return Reduced(scale.asDiagonal() * (inverse + inverse.transpose()) * scale.asDiagonal() / 2);
  };
  const Reduced inverse = take_inverse(scaled);
  const Reduced correction = inverse - kKnown * take_inverse(within_components(scaled));
  piece.inverse.assign(inverse.data(), inverse.data() + inverse.size());
  piece.correction.assign(correction.data(), correction.data() + correction.size());
}

/// By the power method on A_r^-1 D_r, symmetric in the product with D_r.
template <class T>
double Encoder<T>::softness() const {
  constexpr int kSteps = 50;
  double softest = 1;
  for (const Piece& piece : pieces_) {
    const Eigen::Map<const Reduced> A(piece.rest.data()), inverse(piece.inverse.data());
    const Reduced D = within_components(A);
    ReducedVector x = A.diagonal().array().max(1e-300).sqrt().inverse().matrix();
    for (int k = 0; k < kSize; ++k) x(k) *= 1 + 0.1 * (k % 7);  // not orthogonal to any direction
    double value = 1;
    for (int step = 0; step < kSteps; ++step) {
      const ReducedVector Dx = D * x, y = inverse * Dx;
      value = y.dot(Dx) / x.dot(Dx);
      x = y / y.norm();
    }
    softest = std::max(softest, value);
  }
  return softest;
}

template <class T>
void Encoder<T>::set_nodal_stiffness(const std::vector<int32_t>& nodes,
                                     const std::vector<double>& blocks) {
  std::vector<std::vector<double>> A(pieces_.size());
  for (size_t s = 0; s < nodes.size(); ++s) {
    const auto [piece, local] = place_[size_t(nodes[s])];
    if (piece < 0) continue;
    std::vector<double>& sum = A[size_t(piece)];
    if (sum.empty()) sum = pieces_[size_t(piece)].rest;
    const T* mode = pieces_[size_t(piece)].modes.data() + size_t(local) * kModes;
    for (size_t m = 0; m < kModes; ++m)
      for (size_t i = 0; i < 3; ++i) {
        double* row = sum.data() + (3 * m + i) * size_t(kSize);
        for (size_t n = 0; n < kModes; ++n)
          for (size_t j = 0; j < 3; ++j)
            row[3 * n + j] += double(mode[m]) * double(mode[n]) * blocks[9 * s + 3 * i + j];
      }
  }
  for (size_t p = 0; p < pieces_.size(); ++p)
    invert(pieces_[p], A[p].empty() ? pieces_[p].rest : A[p]);
}

/// The modes of node k in packs; the last one goes on into the next node.
template <class T>
void Encoder<T>::load_modes(const Piece& piece, int64_t k, Pack<T> mode[kPacks]) {
  for (int p = 0; p < kPacks; ++p) mode[p] = load(piece.modes.data() + k * kModes + p * kLanes);
}

template <class T>
void Encoder<T>::encode(const T* r, double* y) const {
  constexpr int64_t kChunk = 1024;
  using Partial = std::array<Pack<T>, 3 * kPacks>;
  for (size_t s = 0; s < pieces_.size(); ++s) {
    const Piece& piece = pieces_[s];
    const int64_t n = int64_t(piece.nodes.size());
    std::vector<Partial> partial(size_t((n + kChunk - 1) / kChunk));
    for_blocks(
        n,
        [&](int64_t begin, int64_t end) {
          Partial sum = {};
          for (int64_t k = begin; k < end; ++k) {
            Pack<T> mode[kPacks];
            load_modes(piece, k, mode);
            const T* value = r + 3 * int64_t(piece.nodes[size_t(k)]);
            for (size_t i = 0; i < 3; ++i)
              for (size_t p = 0; p < kPacks; ++p) sum[i * kPacks + p] += mode[p] * value[i];
          }
          partial[size_t(begin / kChunk)] = sum;
        },
        kChunk);
    double* result = y + s * kSize;
    std::fill(result, result + kSize, 0);
    for (const Partial& sum : partial)
      for (int i = 0; i < 3; ++i)
        for (int m = 0; m < kModes; ++m)
          result[3 * m + i] += double(sum[size_t(i * kPacks + m / kLanes)][m % kLanes]);
  }
}

template <class T>
void Encoder<T>::decode(const double* y, T* z) const {
  for (size_t s = 0; s < pieces_.size(); ++s) {
    const Piece& piece = pieces_[s];
    // 0 beyond the last mode
    Pack<T> coefficient[3][kPacks] = {};
    for (int i = 0; i < 3; ++i)
      for (int m = 0; m < kModes; ++m)
        coefficient[i][m / kLanes][m % kLanes] = T(y[int(s) * 3 * kModes + 3 * m + i]);
    for_each(int64_t(piece.nodes.size()), [&](int64_t k) {
      Pack<T> mode[kPacks];
      load_modes(piece, k, mode);
      T* value = z + 3 * int64_t(piece.nodes[size_t(k)]);
      for (int i = 0; i < 3; ++i) {
        Pack<T> sum = {};
        for (int p = 0; p < kPacks; ++p) sum += mode[p] * coefficient[i][p];
        value[i] +=
            ((sum[0] + sum[4]) + (sum[1] + sum[5])) + ((sum[2] + sum[6]) + (sum[3] + sum[7]));
      }
    });
  }
}

template <class T>
void Encoder<T>::add(std::vector<double> Piece::*matrix, const T* r, T* z) {
  encode(r, reduced_.data());
  for (size_t s = 0; s < pieces_.size(); ++s) {
    const Eigen::Map<const Reduced> of((pieces_[s].*matrix).data());
    Eigen::Map<ReducedVector>(solution_.data() + s * kSize).noalias() =
        of * Eigen::Map<const ReducedVector>(reduced_.data() + s * kSize);
  }
  decode(solution_.data(), z);
}

template class Encoder<float>;
template class Encoder<double>;

}  // namespace elastogen
