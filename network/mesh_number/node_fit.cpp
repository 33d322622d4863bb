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

/// Weights of the value at a coarse node of the affine function that fits values at `nodes` best,
/// each weighted with the inverse of its distance to the fourth power.
std::vector<double> fit_weights(const CoarseGrid& coarse, const VoxelGrid& fine, int64_t node,
                                const std::vector<int32_t>& nodes) {
  std::vector<Eigen::Vector4d> basis;
  std::vector<double> weights;
  Eigen::Matrix4d moments = Eigen::Matrix4d::Zero();
  for (const int32_t n : nodes) {
    Eigen::Vector4d b(1, 0, 0, 0);
    for (int d = 0; d < 3; ++d) b[d + 1] = (fine.rest(n, d) - coarse.grid.rest(node, d)) / fine.h;
    const double square = b.squaredNorm() - 1;
    weights.push_back(1 / (square * square));
    basis.push_back(b);
    moments += weights.back() * b * b.transpose();
  }
  const Eigen::Vector4d at_node = moments.ldlt().solve(Eigen::Vector4d(1, 0, 0, 0));
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
