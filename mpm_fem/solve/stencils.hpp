// SPDX-License-Identifier: Apache-2.0
// Which nodes act on one another: lists of nodes of any length (corners of an element, the two ends
// of a spring, the 27 nodes around a particle), and the sparsity that they give a matrix.

#pragma once

#include "core/array.hpp"
#include "mpm_fem/solve/sparse_matrix.hpp"

namespace elastogen::fem {

/// Stencil s has the nodes node[start[s] .. start[s+1]).
struct Stencils {
  std::vector<int64_t> start = {0};  ///< (count + 1)
  std::vector<int32_t> node;

  int64_t count() const { return int64_t(start.size()) - 1; }
  int64_t length(int64_t s) const { return start[size_t(s) + 1] - start[size_t(s)]; }
  const int32_t* nodes(int64_t s) const { return node.data() + start[size_t(s)]; }
  void add(const int32_t* nodes, int64_t length);
  void append(const Stencils& others);
  bool operator==(const Stencils&) const = default;
};

/// The rows of a table as stencils.
/// @param elements    nodes of each, (elements, n)
/// @param first_node  added to all of them
Stencils stencils_of(In<int32_t> elements, int32_t first_node = 0);

/// Stencils around each node: those of node n are list[start[n] .. start[n+1]), ascending.
struct StencilsOfNodes {
  std::vector<int64_t> start;  ///< (nodes + 1)
  std::vector<int32_t> list;
};

/// @throws Error where a stencil has a node below 0 or not below `nodes`
StencilsOfNodes stencils_of_nodes(const Stencils& stencils, int64_t nodes);

/// Zero matrix, (3 nodes, 3 nodes), with entries of each node with itself and with those that share
/// a stencil with it.
/// @throws Error as stencils_of_nodes, and where it has too many entries for 32 bits
SparseMatrix pattern_of(const Stencils& stencils, int64_t nodes);

}  // namespace elastogen::fem
