// SPDX-License-Identifier: Apache-2.0
// Nodes that are no unknowns but follow free ones by fixed weights (affine constraints, as in deal.II),
// so that a field meets a border that cuts voxels (voxelize/dependent_nodes.hpp):
//
//     u_i = sum_m w_im u_m,     m free nodes, the parent nodes of i.

#pragma once

#include "core/array.hpp"

#include <vector>

namespace elastogen {

/// What Scene::pinned says of a node.
enum NodeKind : uint8_t { kFreeNode = 0, kPinnedNode = 1, kDependentNode = 2 };

/// Lists of weighted sums of values of nodes, in the memory of a machine: those of nodes[i] are
/// sources[begin[i]] to sources[begin[i + 1] - 1].
struct WeightedSums {
  const int32_t *nodes = nullptr, *begin = nullptr, *sources = nullptr;
  const double* weights = nullptr;
  int64_t count = 0;  ///< of nodes
};

class DependentNodes {
 public:
  DependentNodes() = default;
  /// @param nodes    the dependent nodes, ascending.
  /// @param begin    of the parent nodes of each in `parents` and `weights`, (nodes + 1).
  /// @throws Error unless the lists fit together and parent nodes are no dependent ones.
  DependentNodes(std::vector<int32_t> nodes, std::vector<int32_t> begin,
                 std::vector<int32_t> parents, std::vector<double> weights);

  bool empty() const { return nodes_.empty(); }
  int64_t count() const { return int64_t(nodes_.size()); }
  int32_t node(int64_t i) const { return nodes_[size_t(i)]; }
  Span<const int32_t> parents(int64_t i) const {
    return {parents_.data() + begin_[size_t(i)], begin_[size_t(i + 1)] - begin_[size_t(i)], 1};
  }
  /// Of its parent nodes, in their order.
  Span<const double> weights(int64_t i) const {
    return {weights_.data() + begin_[size_t(i)], begin_[size_t(i + 1)] - begin_[size_t(i)], 1};
  }
  /// Largest node of the lists, -1 if there is none.
  int32_t last_node() const { return last_node_; }

  /// WeightedSums in vectors.
  struct Sums {
    WeightedSums view() const {
      return {nodes.data(), begin.data(), sources.data(), weights.data(), int64_t(nodes.size())};
    }
    const std::vector<int32_t>&nodes, &begin, &sources;
    const std::vector<double>& weights;
  };
  /// Of fill(), by dependent node, and of fold(), by parent node; for other machines.
  Sums filled() const { return {nodes_, begin_, parents_, weights_}; }
  Sums folded() const { return {all_parents_, first_, children_, child_weights_}; }

  /// values_i = sum w_im values_m at dependent nodes; (nodes, 3).
  template <class T>
  void fill(T* values) const;
  /// The transpose: g_m += sum w_im g_i at parent nodes, in the order of i, then g_i = 0; (nodes, 3).
  template <class T>
  void fold(T* gradient) const;

 private:
  std::vector<int32_t> nodes_, begin_, parents_;
  std::vector<double> weights_;
  int32_t last_node_ = -1;
  // the transposed lists: parent nodes, and the dependent nodes of each
  std::vector<int32_t> all_parents_, first_, children_;
  std::vector<double> child_weights_;
};

}  // namespace elastogen
