// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/encoder.hpp"

#include "network/precondition/encoder_operator.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <array>

namespace elastogen {
namespace {

constexpr int kSize = kReducedSize;
using Reduced = Eigen::Matrix<double, kSize, kSize, Eigen::RowMajor>;
using ReducedVector = Eigen::Matrix<double, kSize, 1>;

/// Bounding box of some nodes at rest.
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
Encoder<T>::Encoder(const IncrementalPotential& potential) {
  build_modes(potential.scene());
  take_operators(potential.scene(), rest_operators(potential, 1));
}

template <class T>
std::optional<Encoder<T>> Encoder<T>::if_soft(const IncrementalPotential& potential, double least) {
  constexpr int64_t kSample = 1 << 16, kSparsest = 16;  // voxels; one block of so many at least
  const int64_t voxels = potential.scene().grid.voxel_count();
  const int64_t stride = std::clamp<int64_t>(voxels / kSample, 1, kSparsest);
  Encoder encoder;
  encoder.build_modes(potential.scene());
  if (stride > 1) {
    encoder.take_operators(potential.scene(), encoder.rest_operators(potential, stride));
    if (encoder.softness() < least) return {};
  }
  encoder.take_operators(potential.scene(), encoder.rest_operators(potential, 1));
  if (encoder.softness() < least) return {};
  return encoder;
}

template <class T>
void Encoder<T>::build_modes(const Scene& scene) {
  place_.resize(size_t(scene.grid.node_count()));
  for_each(scene.grid.node_count(), [&](int64_t n) { place_[size_t(n)] = {-1, -1}; });
  const PinTrees pins(scene);
  for (std::vector<int32_t>& nodes : encoder_pieces(scene.grid)) {
    const auto piece = int32_t(pieces_.size());
    for_each(int64_t(nodes.size()), [&](int64_t k) {
      place_[size_t(nodes[size_t(k)])] = {piece, int32_t(k)};
    });
    pieces_.emplace_back().nodes = std::move(nodes);
    fill_modes(scene, pins, pieces_.back());
  }
  fill_dependent(scene.dependent);
}

/// Modes of dependent nodes follow those of their parent nodes.
template <class T>
void Encoder<T>::fill_dependent(const DependentNodes& dependent) {
  for (int64_t i = 0; i < dependent.count(); ++i) {
    const auto [piece, local] = place_[size_t(dependent.node(i))];
    if (piece < 0) continue;
    Zeroed<T>& modes = pieces_[size_t(piece)].modes;
    const Span<const int32_t> parents = dependent.parents(i);
    double sum[kModes] = {};
    for (int64_t k = 0; k < parents.rows; ++k) {
      const auto [other, place] = place_[size_t(parents(k))];
      for (int m = 0; m < kModes && other == piece; ++m)
        sum[m] += dependent.weights(i)(k) * double(modes[size_t(place) * kModes + size_t(m)]);
    }
    for (int m = 0; m < kModes; ++m)
      modes[size_t(local) * kModes + size_t(m)] = kept_sum(sum[m], T{});
  }
}

template <class T>
void Encoder<T>::fill_modes(const Scene& scene, const PinTrees& pins, Piece& piece) {
  const VoxelGrid& grid = scene.grid;
  const Box box = rest_box(scene, piece.nodes);
  const PlaneCosines cosines(grid.h, lattice_box(grid, piece.nodes),
                             lowest_waves(box, kEncoderCosines), box);
  const ModeShape shape = mode_shape(box, cosines);
  const Zeroed<double> distance = pin_distance(scene, pins, piece.nodes);
  piece.modes.resize((piece.nodes.size() - 1) * kModes + kPacks * kLanes);
  for_each(int64_t(piece.nodes.size()), [&](int64_t k) {
    const int32_t n = piece.nodes[size_t(k)];
    T* mode = piece.modes.data() + k * kModes;
    for_modes<T>(shape, distance[size_t(k)], grid.node_coord.row(n), grid.rest.row(n),
                 [=](int m, T value) { mode[m] = value; });
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
void Encoder<T>::take_operators(const Scene& scene, std::vector<std::vector<double>>&& operators) {
  const double known = known_share(scene);
  for (size_t s = 0; s < pieces_.size(); ++s)
    static_cast<ReducedOperator&>(pieces_[s]) = ReducedOperator(std::move(operators[s]), known);
  reduced_.resize(pieces_.size() * 3 * kModes);
  solution_.resize(reduced_.size());
}

template <class T>
double Encoder<T>::softness() const {
  double softest = 1;
  for (const Piece& piece : pieces_) softest = std::max(softest, piece.ReducedOperator::softness());
  return softest;
}

/// A of the pieces += B^T K B, K the blocks of the nodes.
template <class T>
void Encoder<T>::add_nodal(const std::vector<int32_t>& nodes, const std::vector<double>& blocks,
                           std::vector<std::vector<double>>& A) const {
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
}

template <class T>
void Encoder<T>::set_nodal_stiffness(const std::vector<int32_t>& nodes,
                                     const std::vector<double>& blocks) {
  std::vector<std::vector<double>> A(pieces_.size());
  add_nodal(nodes, blocks, A);
  for (size_t p = 0; p < pieces_.size(); ++p)
    pieces_[p].invert(A[p].empty() ? pieces_[p].rest : A[p]);
}

template <class T>
void Encoder<T>::set_inertia(const Scene& scene, double built, double wanted) {
  const size_t square = size_t(kSize) * size_t(kSize);
  if (inertia_.empty()) {  // what A_r was built with: B^T (a0 m / dt^2) B, and the rest of it
    std::vector<int32_t> nodes;
    std::vector<double> blocks;
    for (int64_t n = 0; n < scene.grid.node_count(); ++n) {
      if (scene.pinned(n) == kPinnedNode) continue;
      nodes.push_back(int32_t(n));
      for (int k = 0; k < 9; ++k) blocks.push_back(k % 4 == 0 ? built * scene.mass(n) : 0);
    }
    inertia_.assign(pieces_.size(), std::vector<double>(square));
    add_nodal(nodes, blocks, inertia_);
    for (size_t p = 0; p < pieces_.size(); ++p) {
      elastic_.push_back(pieces_[p].rest);
      for (size_t k = 0; k < square; ++k) elastic_[p][k] -= inertia_[p][k];
    }
  }
  for (size_t p = 0; p < pieces_.size(); ++p) {
    for (size_t k = 0; k < square; ++k)
      pieces_[p].rest[k] = elastic_[p][k] + wanted / built * inertia_[p][k];
    pieces_[p].invert(pieces_[p].rest);
  }
}

/// The modes of node k in packs; the last pack runs on into the next node, or into zeros.
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
    // sums of chunks, each in packs of modes
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
    // added in float64, in the order of the chunks
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
    // coefficients in packs, 0 beyond the last mode
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
void Encoder<T>::add(std::vector<double> ReducedOperator::*matrix, const T* r, T* z) {
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
