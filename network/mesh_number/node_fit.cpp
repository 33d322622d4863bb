// SPDX-License-Identifier: Apache-2.0
#include "core/parallel.hpp"
#include "network/mesh_number/coarse_grid.hpp"

#include <Eigen/Dense>

#include <algorithm>

namespace elastogen {
namespace {

/// The nodes of all children of the voxels around a coarse node, in order.
std::vector<int32_t> nodes_around(const CoarseGrid& coarse, const VoxelGrid& fine, int64_t node) {
  std::vector<int32_t> nodes;
  for (int c = 0; c < 8; ++c) {
    const int32_t voxel = coarse.grid.voxels(node, c);
    for (int k = 0; k < 8 && voxel >= 0; ++k) {
      const int32_t child = coarse.children(voxel, k);
      if (child >= 0)
        nodes.insert(nodes.end(), fine.corners.row(child), fine.corners.row(child) + 8);
    }
  }
  std::sort(nodes.begin(), nodes.end());
  nodes.erase(std::unique(nodes.begin(), nodes.end()), nodes.end());
  return nodes;
}

using Basis = Eigen::Matrix<double, 10, 1>;  // 1, x, y, z, then the products of two

constexpr double kRidge = 0.01;  // on the coefficients of products: those that no node tells are 0

/// Weights of the value at a coarse node of the function that fits values at `nodes` best, each
/// weighted with the inverse of its distance to the fourth power: affine functions are met exactly,
/// quadratic ones as far as the nodes tell them apart.
std::vector<double> fit_weights(const CoarseGrid& coarse, const VoxelGrid& fine, int64_t node,
                                const std::vector<int32_t>& nodes) {
  // moments of the basis
  std::vector<Basis> basis;
  std::vector<double> weights;
  Eigen::Matrix<double, 10, 10> moments = decltype(moments)::Zero();
  for (int k = 4; k < 10; ++k) moments(k, k) = kRidge;
  for (const int32_t n : nodes) {
    double r[3], square = 0;
    for (int d = 0; d < 3; ++d) {
      r[d] = (fine.rest(n, d) - coarse.grid.rest(node, d)) / fine.h;
      square += r[d] * r[d];
    }
    Basis b;
    b << 1, r[0], r[1], r[2], r[0] * r[0], r[1] * r[1], r[2] * r[2], r[0] * r[1], r[1] * r[2],
        r[2] * r[0];
    basis.push_back(b);
    weights.push_back(1 / (square * square));
    moments += weights.back() * b * b.transpose();
  }
  // the value of the fit where r = 0
  const Basis at_node = moments.ldlt().solve(Basis::Unit(0));
  for (size_t k = 0; k < weights.size(); ++k) weights[k] *= basis[k].dot(at_node);
  return weights;
}

}  // namespace

NodeFit::NodeFit(const CoarseGrid& coarse, const VoxelGrid& fine) {
  begin_.push_back(0);
  for (int64_t n = 0; n < coarse.grid.node_count(); ++n) {
    const int32_t same = coarse.around(n, kSamePlace);
    const std::vector<int32_t> nodes =
        same >= 0 ? std::vector<int32_t>{same} : nodes_around(coarse, fine, n);
    const std::vector<double> weights =
        same >= 0 ? std::vector<double>{1} : fit_weights(coarse, fine, n, nodes);
    node_.insert(node_.end(), nodes.begin(), nodes.end());
    weight_.insert(weight_.end(), weights.begin(), weights.end());
    begin_.push_back(int64_t(node_.size()));
  }
}

void NodeFit::apply(const double* fine, double* values) const {
  for_each(int64_t(begin_.size()) - 1, [&](int64_t n) {
    double sum[3] = {};
    for (int64_t k = begin_[size_t(n)]; k < begin_[size_t(n) + 1]; ++k)
      for (int i = 0; i < 3; ++i)
        sum[i] += weight_[size_t(k)] * fine[3 * int64_t(node_[size_t(k)]) + i];
    for (int i = 0; i < 3; ++i) values[3 * n + i] = sum[i];
  });
}

}  // namespace elastogen
