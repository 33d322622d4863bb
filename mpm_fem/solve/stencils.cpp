// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/stencils.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <limits>

namespace elastogen::fem {

void Stencils::add(const int32_t* nodes, int64_t length) {
  node.insert(node.end(), nodes, nodes + length);
  start.push_back(int64_t(node.size()));
}

void Stencils::append(const Stencils& others) {
  const int64_t before = start.back();
  node.insert(node.end(), others.node.begin(), others.node.end());
  for (int64_t s = 1; s <= others.count(); ++s) start.push_back(before + others.start[size_t(s)]);
}

Stencils stencils_of(In<int32_t> elements, int32_t first_node) {
  Stencils stencils;
  stencils.node.assign(elements.data, elements.data + elements.size());
  for (int32_t& n : stencils.node) n += first_node;
  for (int64_t e = 1; e <= elements.rows; ++e) stencils.start.push_back(e * elements.cols);
  return stencils;
}

StencilsOfNodes stencils_of_nodes(const Stencils& stencils, int64_t nodes) {
  StencilsOfNodes result;
  result.start.resize(size_t(nodes) + 1);
  for (const int32_t n : stencils.node) {
    ELASTOGEN_CHECK(n >= 0 && n < nodes, "a stencil has node ", n, " of ", nodes);
    ++result.start[size_t(n) + 1];
  }
  for (size_t n = 0; n < size_t(nodes); ++n) result.start[n + 1] += result.start[n];
  result.list.resize(stencils.node.size());
  std::vector<int64_t> next(result.start.begin(), result.start.end() - 1);
  for (int64_t s = 0; s < stencils.count(); ++s)
    for (int64_t a = 0; a < stencils.length(s); ++a)
      result.list[size_t(next[size_t(stencils.nodes(s)[a])]++)] = int32_t(s);
  return result;
}

SparseMatrix pattern_of(const Stencils& stencils, int64_t nodes) {
  const StencilsOfNodes around = stencils_of_nodes(stencils, nodes);
  // neighbours of each node, itself included, ascending
  std::vector<std::vector<int32_t>> neighbours(static_cast<size_t>(nodes));
  for_each(nodes, [&](int64_t n) {
    std::vector<int32_t>& list = neighbours[size_t(n)];
    list.push_back(int32_t(n));
    for (int64_t k = around.start[size_t(n)]; k < around.start[size_t(n) + 1]; ++k) {
      const int32_t s = around.list[size_t(k)];
      list.insert(list.end(), stencils.nodes(s), stencils.nodes(s) + stencils.length(s));
    }
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  });
  int64_t entries = 0;
  for (const std::vector<int32_t>& list : neighbours) entries += 9 * int64_t(list.size());
  ELASTOGEN_CHECK(entries <= std::numeric_limits<int32_t>::max(), "a matrix of ", nodes,
                  " nodes has ", entries, " entries, more than 2^31 - 1");
  SparseMatrix pattern;
  pattern.start.push_back(0);
  pattern.column.reserve(size_t(entries));
  for (int64_t n = 0; n < nodes; ++n)
    for (int i = 0; i < 3; ++i) {
      for (const int32_t m : neighbours[size_t(n)])
        for (int j = 0; j < 3; ++j) pattern.column.push_back(3 * m + j);
      pattern.start.push_back(int32_t(pattern.column.size()));
    }
  pattern.value.resize(pattern.column.size());
  return pattern;
}

}  // namespace elastogen::fem
