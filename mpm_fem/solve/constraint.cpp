// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/constraint.hpp"

#include "core/error.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

/// Row `to` of A += factor times row `from`, whose columns it has.
void fold_row(double factor, int64_t from, int64_t to, SparseMatrix& A) {
  int32_t k = A.start[size_t(to)];
  for (int32_t l = A.start[size_t(from)]; l < A.start[size_t(from) + 1]; ++l) {
    while (A.column[size_t(k)] < A.column[size_t(l)]) ++k;
    A.value[size_t(k)] += factor * A.value[size_t(l)];
  }
}

}  // namespace

Constraint::Constraint(DependentNodes dependent)
    : dependent_(std::move(dependent)), place_(size_t(dependent_.last_node() + 1), -1) {
  for (int64_t i = 0; i < dependent_.count(); ++i) place_[size_t(dependent_.node(i))] = int32_t(i);
}

void Constraint::set_offset(In<double> offset) {
  ELASTOGEN_CHECK(offset.is(dependent_.count(), 3), "offsets must be (dependent nodes, 3) with ",
                  dependent_.count(), " nodes, got ", offset);
  if (offset_.empty()) offset_ = Array<double>(offset.rows, 3);
  std::copy_n(offset.data, offset.size(), offset_.data());
}

template <class Use>
void Constraint::for_parents(int64_t i, const Use& use) const {
  const Span<const int32_t> parents = dependent_.parents(i);
  const Span<const double> weights = dependent_.weights(i);
  for (int64_t k = 0; k < parents.rows; ++k) use(int64_t(parents(k)), weights(k));
}

void Constraint::place(double* u) const {
  dependent_.fill(u);
  for (int64_t i = 0; i < offset_.rows(); ++i)
    for (int d = 0; d < 3; ++d) u[3 * int64_t(dependent_.node(i)) + d] += offset_(i, d);
}

void Constraint::fold(SparseMatrix& H) const {
  // rows of dependent nodes
  for (int64_t i = 0; i < dependent_.count(); ++i)
    for_parents(i, [&](int64_t m, double weight) {
      for (int d = 0; d < 3; ++d)
        fold_row(weight, 3 * int64_t(dependent_.node(i)) + d, 3 * m + d, H);
    });
  // their columns, in the rows of their neighbours
  for (int64_t i = 0; i < dependent_.count(); ++i) {
    const int64_t node = dependent_.node(i);
    const int32_t begin = H.start[size_t(3 * node)], end = H.start[size_t(3 * node) + 1];
    for (int32_t k = begin; k < end; k += 3) {
      const int64_t n = H.column[size_t(k)] / 3;
      if (n < int64_t(place_.size()) && place_[size_t(n)] >= 0) continue;
      const int32_t from = H.block_place(n, node);
      for_parents(i, [&](int64_t m, double weight) {
        const int32_t to = H.block_place(n, m);
        for (int64_t r = 3 * n; r < 3 * n + 3; ++r)
          for (int32_t d = 0; d < 3; ++d) {
            double* row = H.value.data() + H.start[size_t(r)];
            row[to + d] += weight * row[from + d];
          }
      });
      for (int64_t r = 3 * n; r < 3 * n + 3; ++r)
        std::fill_n(H.value.data() + H.start[size_t(r)] + from, 3, 0.0);
    }
  }
  // nothing is left by them
  for (int64_t i = 0; i < dependent_.count(); ++i) {
    const auto first = size_t(3 * int64_t(dependent_.node(i)));
    std::fill(H.value.begin() + H.start[first], H.value.begin() + H.start[first + 3], 0.0);
  }
}

Stencils Constraint::widened(const Stencils& stencils) const {
  Stencils result;
  std::vector<int32_t> nodes;
  for (int64_t s = 0; s < stencils.count(); ++s) {
    nodes.assign(stencils.nodes(s), stencils.nodes(s) + stencils.length(s));
    for (int64_t a = 0; a < stencils.length(s); ++a) {
      const auto n = size_t(stencils.nodes(s)[a]);
      if (n >= place_.size() || place_[n] < 0) continue;
      for_parents(place_[n], [&](int64_t m, double) {
        if (std::ranges::find(nodes, int32_t(m)) == nodes.end()) nodes.push_back(int32_t(m));
      });
    }
    result.add(nodes.data(), int64_t(nodes.size()));
  }
  return result;
}

void Constraint::mark(std::vector<uint8_t>& unknowns) const {
  for (int64_t i = 0; i < dependent_.count(); ++i)
    std::fill_n(unknowns.begin() + 3 * int64_t(dependent_.node(i)), 3, uint8_t(1));
}

}  // namespace elastogen::fem
