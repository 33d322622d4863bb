// SPDX-License-Identifier: Apache-2.0
#include "network/encoder_operator.hpp"

#include "core/parallel.hpp"
#include "network/encoder.hpp"

#include <Eigen/Core>

#include <algorithm>

namespace elastogen {
namespace {

constexpr int kModes = Encoder<float>::kModes, kAxes = 3 * kModes, kBlockVoxels = 128;
constexpr int64_t kMostParts = 64;     // partial sums, whatever the number of voxels
constexpr int kAcross[3] = {1, 2, 0};  // the patterns yz, zx, xy across x, y, z

/// A line a voxel or node; column M a + m is axis or pattern a of mode m.
template <int kColumns>
using Block = Eigen::Matrix<double, Eigen::Dynamic, kColumns, Eigen::RowMajor>;
using Product = Eigen::Matrix<double, kAxes, kAxes>;
using ModeProduct = Eigen::Matrix<double, kModes, kModes>;

/// Products of the modes over some voxels and nodes.
struct Products {
  Product mu = Product::Zero(), lambda = Product::Zero();  ///< phi h^3 times modulus, d_ma d_nb
  Product torsion = Product::Zero();                       ///< phi h mu/48 q_ma q_nb
  ModeProduct variance[4] = {ModeProduct::Zero(), ModeProduct::Zero(), ModeProduct::Zero(),
                             ModeProduct::Zero()};  ///< phi h w_k c_k q_mk q_nk
  ModeProduct inertia = ModeProduct::Zero();

  void add(const Products& o) {
    mu += o.mu, lambda += o.lambda, torsion += o.torsion, inertia += o.inertia;
    for (int k = 0; k < 4; ++k) variance[k] += o.variance[k];
  }
};

/// What a block of voxels brings to the products.
struct VoxelBlock {
  explicit VoxelBlock(Eigen::Index n) : gradient(n, kAxes), patterns(n, 4 * kModes) {
    for (Eigen::VectorXd* w : {&mu, &lambda, &torsion, &c[0], &c[1], &c[2], &c[3]}) w->resize(n);
  }
  Block<kAxes> gradient;
  Block<4 * kModes> patterns;
  Eigen::VectorXd mu, lambda, torsion, c[4];  ///< weights of the voxels

  template <class T>
  void set(Eigen::Index line, const Scene& scene, int64_t v, const PieceModes<T>& piece);
  void add_to(Products& sum, Hourglass hourglass) const;
};

template <class T>
void VoxelBlock::set(Eigen::Index line, const Scene& scene, int64_t v, const PieceModes<T>& piece) {
  const VoxelGrid& grid = scene.grid;
  const double h = grid.h, phi = grid.fill(v);
  const Material& m = scene.materials[size_t(scene.material(v))];
  mu(line) = phi * h * h * h * m.mu();
  lambda(line) = phi * h * h * h * m.lambda();
  torsion(line) = phi * h * m.mu() / 48;
  for (int k = 0; k < 4; ++k)
    c[k](line) = phi * h * scene.variance(v, k) * (k < 3 ? 1.0 / 24 : 1.0 / 48);
  double M[7];
  hex8::fill_moments(grid.shape_mean.row(v), M);
  const T* corner[8];
  for (int k = 0; k < 8; ++k)
    corner[k] = piece.values.data() + size_t(piece.place[size_t(grid.corners(v, k))]) * kModes;
  for (int mode = 0; mode < kModes; ++mode) {
    double g[8], d[3], q[4];
    for (int k = 0; k < 8; ++k) g[k] = double(corner[k][mode]);
    hex8::to_patterns(g);
    hex8::gradient<true>(g, M, d);
    hex8::centred_patterns<true>(g, M, q);
    for (int a = 0; a < 3; ++a) gradient(line, a * kModes + mode) = d[a] / (4 * h);
    for (int k = 0; k < 4; ++k) patterns(line, k * kModes + mode) = q[k];
  }
}

/// The lower half of sum += A^T diag(w) A, w >= 0.
template <class A, class Sum>
void add_product(const A& a, const Eigen::VectorXd& w, Sum& sum) {
  const Block<A::ColsAtCompileTime> weighted = w.cwiseSqrt().asDiagonal() * a;
  sum.template selfadjointView<Eigen::Lower>().rankUpdate(weighted.transpose());
}

/// The upper half from the lower one.
template <class Sum>
void mirror(Sum& sum) {
  sum.template triangularView<Eigen::StrictlyUpper>() = sum.transpose();
}

void VoxelBlock::add_to(Products& sum, Hourglass hourglass) const {
  add_product(gradient, mu, sum.mu);
  add_product(gradient, lambda, sum.lambda);
  if (hourglass == Hourglass::kOff) return;
  for (int k = 0; k < 4; ++k)
    add_product(patterns.middleCols<kModes>(k * kModes), c[k], sum.variance[k]);
  if (hourglass == Hourglass::kFull) add_product(patterns.leftCols<kAxes>(), torsion, sum.torsion);
}

/// part(first, last, sums) over equal shares of [0, n), as many on every machine.
template <class Part>
Products sum_of_parts(int64_t n, const Part& part) {
  const int64_t share = std::max<int64_t>(8 * kBlockVoxels, (n + kMostParts - 1) / kMostParts);
  std::vector<Products, Eigen::aligned_allocator<Products>> parts(size_t((n + share - 1) / share));
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
Products voxel_products(const Scene& scene, const PieceModes<T>& piece) {
  return sum_of_parts(int64_t(piece.voxels.size()),
                      [&](int64_t first, int64_t last, Products& sum) {
                        for (int64_t from = first; from < last; from += kBlockVoxels) {
                          const int64_t to = std::min(last, from + kBlockVoxels);
                          VoxelBlock block(to - from);
                          for (int64_t k = from; k < to; ++k)
                            block.set(k - from, scene, piece.voxels[size_t(k)], piece);
                          block.add_to(sum, scene.hourglass);
                        }
                      });
}

template <class T>
ModeProduct inertia_products(const IncrementalPotential& potential, const PieceModes<T>& piece) {
  const auto nodes = int64_t(piece.nodes.size());
  return sum_of_parts(nodes,
                      [&](int64_t first, int64_t last, Products& sum) {
                        for (int64_t from = first; from < last; from += kBlockVoxels) {
                          const int64_t to = std::min(last, from + kBlockVoxels);
                          Block<kModes> modes(to - from, kModes);
                          Eigen::VectorXd inertia(to - from);
                          for (int64_t k = from; k < to; ++k) {
                            inertia(k - from) = potential.inertia(piece.nodes[size_t(k)]);
                            for (int m = 0; m < kModes; ++m)
                              modes(k - from, m) =
                                  double(piece.values[size_t(k) * kModes + size_t(m)]);
                          }
                          add_product(modes, inertia, sum.inertia);
                        }
                      })
      .inertia;
}

}  // namespace

template <class T>
std::vector<double> reduced_rest_operator(const IncrementalPotential& potential,
                                          const PieceModes<T>& piece) {
  const Products p = voxel_products(potential.scene(), piece);
  // what is alike for the three components
  ModeProduct alike = inertia_products(potential, piece);
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
                                                   const PieceModes<float>&);
template std::vector<double> reduced_rest_operator(const IncrementalPotential&,
                                                   const PieceModes<double>&);

}  // namespace elastogen
