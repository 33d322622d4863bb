// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/encoder_operator.hpp"

#include "core/parallel.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int kModes = Encoder<float>::kModes, kPacks = Encoder<float>::kPacks;
constexpr int kAxes = 3 * kModes, kBlockVoxels = 128;
constexpr int64_t kMostParts = 64;     // partial sums, for any number of voxels
constexpr int kAcross[3] = {1, 2, 0};  // the patterns yz, zx, xy across x, y, z

/// One line for each voxel or node; column M a + m is axis or pattern a of mode m.
template <int kColumns>
using Block = Eigen::Matrix<double, Eigen::Dynamic, kColumns, Eigen::RowMajor>;
using Product = Eigen::Matrix<double, kAxes, kAxes>;
using ModeProduct = Eigen::Matrix<double, kModes, kModes>;

/// Products of the modes over some voxels and nodes.
struct ModeProducts {
  Product mu = Product::Zero(), lambda = Product::Zero();  ///< phi h^3 times modulus, d_ma d_nb
  Product torsion = Product::Zero();                       ///< phi h mu/48 q_ma q_nb
  ModeProduct variance[4] = {ModeProduct::Zero(), ModeProduct::Zero(), ModeProduct::Zero(),
                             ModeProduct::Zero()};  ///< phi h w_k c_k q_mk q_nk
  ModeProduct inertia = ModeProduct::Zero();

  void add(const ModeProducts& o) {
    mu += o.mu, lambda += o.lambda, torsion += o.torsion, inertia += o.inertia;
    for (int k = 0; k < 4; ++k) variance[k] += o.variance[k];
  }
};

/// Ratios of a voxel's other weights to its weight in the product mu.
struct Ratios {
  double lambda, c[4];  ///< of lambda h^3 to mu h^3, of h w_k c_k to h mu / 48
  bool operator==(const Ratios&) const = default;
};

/// The lower half of A^T A.
template <class A>
auto square_of(const A& a) {
  constexpr int kColumns = A::ColsAtCompileTime;
  Eigen::Matrix<double, kColumns, kColumns> square =
      Eigen::Matrix<double, kColumns, kColumns>::Zero();
  square.template selfadjointView<Eigen::Lower>().rankUpdate(a.transpose());
  return square;
}

/// The lower half of A^T diag(w) A, w >= 0.
template <class A>
auto weighted_square_of(const A& a, const Eigen::VectorXd& w) {
  const Block<A::ColsAtCompileTime> weighted = w.cwiseSqrt().asDiagonal() * a;
  return square_of(weighted);
}

/// A block of voxels for the products: d and q times the roots of their weights in mu and torsion,
/// and the ratios.
class VoxelBlock {
 public:
  VoxelBlock()
      : gradient_(size_t(kBlockVoxels) * kAxes + kLanes),
        patterns_(size_t(kBlockVoxels) * 4 * kModes + kLanes),
        ratios_(kBlockVoxels) {}

  template <class T>
  void set(int line, const Scene& scene, int64_t v, const PieceModes<T>& piece);
  /// Adds the first `lines` voxels.
  void add_to(ModeProducts& sum, Eigen::Index lines, Hourglass hourglass) const;

 private:
  template <int kColumns>
  using Lines = Eigen::Map<const Block<kColumns>>;
  void add_unlike(ModeProducts& sum, Eigen::Index lines, Hourglass hourglass) const;

  std::vector<double> gradient_, patterns_;
  std::vector<Ratios> ratios_;
};

/// Sets a line from a voxel. Modes are stored in packs, and what a pack writes beyond the last mode
/// is overwritten by the next axis or line.
template <class T>
void VoxelBlock::set(int line, const Scene& scene, int64_t v, const PieceModes<T>& piece) {
  const VoxelGrid& grid = scene.grid;
  const Material& material = scene.materials[size_t(scene.material(v))];
  const double h = grid.h, weight = grid.fill(v) * h * material.mu();
  // ratios of the other weights to mu
  Ratios& ratios = ratios_[size_t(line)];
  ratios.lambda = material.lambda() / material.mu();
  for (int k = 0; k < 4; ++k) ratios.c[k] = (k < 3 ? 2 : 1) * scene.variance(v, k) / material.mu();
  double moments[7];
  hex8::fill_moments(grid.shape_mean.row(v), moments);
  Pack<double> M[7];
  for (int p = 0; p < 7; ++p) M[p] = constant<Pack<double>>(moments[p]);
  // gradients and patterns of the modes, in packs
  const T* corner[8];
  for (int k = 0; k < 8; ++k)
    corner[k] =
        piece.values.data() + size_t(piece.place[size_t(grid.corners(v, k))].local) * kModes;
  const double of_gradient = std::sqrt(weight) / 4, of_patterns = std::sqrt(weight / 48);
  Pack<double> d[kPacks][3], q[kPacks][4];
  for (int pack = 0; pack < kPacks; ++pack) {
    Pack<double> g[8];
    for (int k = 0; k < 8; ++k)
      g[k] = __builtin_convertvector(load(corner[k] + pack * kLanes), Pack<double>);
    hex8::to_patterns(g);
    hex8::gradient<true>(g, M, d[pack]);
    hex8::centred_patterns<true>(g, M, q[pack]);
  }
  // times the roots of their weights in mu and torsion
  double* to = gradient_.data() + line * kAxes;
  for (int a = 0; a < 3; ++a, to += kModes)
    for (int pack = 0; pack < kPacks; ++pack) store(to + pack * kLanes, d[pack][a] * of_gradient);
  to = patterns_.data() + line * 4 * kModes;
  for (int k = 0; k < 4; ++k, to += kModes)
    for (int pack = 0; pack < kPacks; ++pack) store(to + pack * kLanes, q[pack][k] * of_patterns);
}

/// Copies the lower half to the upper one.
template <class Sum>
void mirror(Sum& sum) {
  sum.template triangularView<Eigen::StrictlyUpper>() = sum.transpose();
}

void VoxelBlock::add_to(ModeProducts& sum, Eigen::Index lines, Hourglass hourglass) const {
  const bool alike = std::equal(ratios_.begin() + 1, ratios_.begin() + lines, ratios_.begin());
  const Product mu = square_of(Lines<kAxes>(gradient_.data(), lines, kAxes));
  sum.mu += mu;
  if (!alike || hourglass != Hourglass::kFull) return add_unlike(sum, lines, hourglass);
  const Lines<4 * kModes> patterns(patterns_.data(), lines, 4 * kModes);
  const Ratios& ratios = ratios_[0];
  const Product torsion = square_of(patterns.leftCols<kAxes>());
  sum.lambda += ratios.lambda * mu;
  sum.torsion += torsion;
  for (int k = 0; k < 3; ++k)
    sum.variance[k] += ratios.c[k] * torsion.block<kModes, kModes>(k * kModes, k * kModes);
  sum.variance[3] += ratios.c[3] * square_of(patterns.rightCols<kModes>());
}

/// Adds all but mu, with the ratios of each voxel.
void VoxelBlock::add_unlike(ModeProducts& sum, Eigen::Index lines, Hourglass hourglass) const {
  Eigen::VectorXd w(lines);
  for (Eigen::Index line = 0; line < lines; ++line) w(line) = ratios_[size_t(line)].lambda;
  sum.lambda += weighted_square_of(Lines<kAxes>(gradient_.data(), lines, kAxes), w);
  if (hourglass == Hourglass::kOff) return;
  const Lines<4 * kModes> patterns(patterns_.data(), lines, 4 * kModes);
  for (int k = 0; k < 4; ++k) {
    for (Eigen::Index line = 0; line < lines; ++line) w(line) = ratios_[size_t(line)].c[k];
    sum.variance[k] += weighted_square_of(patterns.middleCols<kModes>(k * kModes), w);
  }
  if (hourglass == Hourglass::kFull) sum.torsion += square_of(patterns.leftCols<kAxes>());
}

/// Sum of part(first, last, sums) over equal shares of [0, n), as many on every machine; first is a
/// multiple of kBlockVoxels.
template <class Part>
ModeProducts sum_of_parts(int64_t n, const Part& part) {
  const int64_t share =
      std::max<int64_t>(8, (n / kBlockVoxels + kMostParts) / kMostParts) * kBlockVoxels;
  std::vector<ModeProducts, Eigen::aligned_allocator<ModeProducts>> parts(
      size_t((n + share - 1) / share));
  for_blocks(
      n, [&](int64_t first, int64_t last) { part(first, last, parts[size_t(first / share)]); },
      share);
  for (size_t k = 1; k < parts.size(); ++k) parts[0].add(parts[k]);
  for (Product* sum : {&parts[0].mu, &parts[0].lambda, &parts[0].torsion}) mirror(*sum);
  for (ModeProduct& sum : parts[0].variance) mirror(sum);
  mirror(parts[0].inertia);
  return parts[0];
}

template <class T>
ModeProducts voxel_products(const Scene& scene, const PieceModes<T>& piece, int64_t stride) {
  return sum_of_parts(int64_t(piece.voxels.size()),
                      [&](int64_t first, int64_t last, ModeProducts& sum) {
                        VoxelBlock block;
                        for (int64_t from = first; from < last; from += kBlockVoxels) {
                          if (from / kBlockVoxels % stride != 0) continue;
                          const int64_t to = std::min(last, from + kBlockVoxels);
                          for (int64_t k = from; k < to; ++k)
                            block.set(int(k - from), scene, piece.voxels[size_t(k)], piece);
                          block.add_to(sum, to - from, scene.hourglass);
                        }
                      });
}

template <class T>
ModeProduct inertia_products(const IncrementalPotential& potential, const PieceModes<T>& piece,
                             int64_t stride) {
  return sum_of_parts(int64_t(piece.nodes.size()),
                      [&](int64_t first, int64_t last, ModeProducts& sum) {
                        Block<kModes> modes(kBlockVoxels, kModes);
                        for (int64_t from = first; from < last; from += kBlockVoxels) {
                          if (from / kBlockVoxels % stride != 0) continue;
                          const int64_t to = std::min(last, from + kBlockVoxels);
                          for (int64_t k = from; k < to; ++k) {
                            const double root =
                                std::sqrt(potential.inertia(piece.nodes[size_t(k)]));
                            for (int m = 0; m < kModes; ++m)
                              modes(k - from, m) =
                                  root * double(piece.values[size_t(k) * kModes + size_t(m)]);
                          }
                          sum.inertia += square_of(modes.topRows(to - from));
                        }
                      })
      .inertia;
}

}  // namespace

template <class T>
std::vector<double> reduced_rest_operator(const IncrementalPotential& potential,
                                          const PieceModes<T>& piece, int64_t stride) {
  const ModeProducts p = voxel_products(potential.scene(), piece, stride);
  // the part that all three components share
  ModeProduct alike = inertia_products(potential, piece, stride);
  for (int a = 0; a < 3; ++a) alike += p.mu.block<kModes, kModes>(a * kModes, a * kModes);
  for (const ModeProduct& variance : p.variance) alike += variance;
  std::vector<double> A(size_t(kAxes) * kAxes);
  for (int m = 0; m < kModes; ++m)
    for (int i = 0; i < 3; ++i)
      for (int n = 0; n < kModes; ++n)
        for (int j = 0; j < 3; ++j) {
          const int a = kAcross[i], b = kAcross[j];
          double sum =
              p.mu(j * kModes + m, i * kModes + n) + p.lambda(i * kModes + m, j * kModes + n);
          if (potential.scene().hourglass == Hourglass::kFull)
            sum += (i == j ? 2 : 1) * p.torsion(a * kModes + m, b * kModes + n) -
                   (i == j ? p.variance[a](m, n) : 0);
          A[size_t((3 * m + i) * kAxes + 3 * n + j)] = sum + (i == j ? alike(m, n) : 0);
        }
  return A;
}

template std::vector<double> reduced_rest_operator(const IncrementalPotential&,
                                                   const PieceModes<float>&, int64_t);
template std::vector<double> reduced_rest_operator(const IncrementalPotential&,
                                                   const PieceModes<double>&, int64_t);

}  // namespace elastogen
