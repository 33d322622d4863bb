// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/assembly.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

constexpr int64_t kStencilBlock = 32;  // stencils of a task

}  // namespace

Assembly::Assembly(Stencils stencils, int64_t nodes) : stencils_(std::move(stencils)) {
  square_.push_back(0);
  for (int64_t s = 0; s < stencils_.count(); ++s) {
    const int64_t length = stencils_.length(s);
    longest_ = std::max(longest_, length);
    square_.push_back(square_.back() + length * length);
  }
  make_colours(nodes);
}

void Assembly::fit(const SparseMatrix& pattern) {
  place_.resize(size_t(square_.back()));
  for_each(stencils_.count(), [&](int64_t s) {
    int32_t* place = place_.data() + square_[size_t(s)];
    const int32_t* nodes = stencils_.nodes(s);
    const int64_t length = stencils_.length(s);
    for (int64_t a = 0; a < length; ++a)
      for (int64_t b = 0; b < length; ++b) *place++ = pattern.block_place(nodes[a], nodes[b]);
  });
  rows_ = pattern.rows();
  entries_ = pattern.entries();
}

void Assembly::make_colours(int64_t nodes) {
  const StencilsOfNodes around = stencils_of_nodes(stencils_, nodes);
  std::vector<int32_t> colour(size_t(stencils_.count()), -1);
  std::vector<int64_t> taken;  // last stencil that saw a colour on a neighbour
  std::vector<int64_t> count;
  for (int64_t s = 0; s < stencils_.count(); ++s) {
    for (int64_t a = 0; a < stencils_.length(s); ++a) {
      const size_t n = size_t(stencils_.nodes(s)[a]);
      for (int64_t k = around.start[n]; k < around.start[n + 1]; ++k)
        if (const int32_t c = colour[size_t(around.list[size_t(k)])]; c >= 0) taken[size_t(c)] = s;
    }
    size_t c = 0;
    while (c < taken.size() && taken[c] == s) ++c;
    if (c == taken.size()) taken.push_back(-1), count.push_back(0);
    colour[size_t(s)] = int32_t(c);
    ++count[c];
  }
  colours_.assign(1, 0);
  for (const int64_t k : count) colours_.push_back(colours_.back() + k);
  by_colour_.resize(size_t(stencils_.count()));
  std::vector<int64_t> next(colours_.begin(), colours_.end() - 1);
  for (int64_t s = 0; s < stencils_.count(); ++s)
    by_colour_[size_t(next[size_t(colour[size_t(s)])]++)] = int32_t(s);
}

void Assembly::add_one(int64_t s, const double* K, SparseMatrix& A) const {
  const int length = int(stencils_.length(s)), width = 3 * length;
  const int32_t* nodes = stencils_.nodes(s);
  const int32_t* place = place_.data() + square_[size_t(s)];
  for (int a = 0; a < length; ++a)
    for (int i = 0; i < 3; ++i) {
      double* values = A.value.data() + A.start[size_t(3 * int64_t(nodes[a]) + i)];
      const double* from = K + (3 * a + i) * width;
      for (int b = 0; b < length; ++b)
        for (int j = 0; j < 3; ++j) values[place[a * length + b] + j] += from[3 * b + j];
    }
}

void Assembly::add(const StencilMatrix& stencil_matrix, SparseMatrix& A) const {
  ELASTOGEN_CHECK(A.rows() == rows_ && A.entries() == entries_,
                  "the matrix must have the pattern that the assembly was fitted to");
  for (size_t c = 0; c + 1 < colours_.size(); ++c)
    for_blocks(
        colours_[c + 1] - colours_[c],
        [&](int64_t begin, int64_t end) {
          std::vector<double> K(size_t(9 * longest_ * longest_));
          for (int64_t k = begin; k < end; ++k) {
            const int32_t s = by_colour_[size_t(colours_[c] + k)];
            stencil_matrix(s, K.data());
            add_one(s, K.data(), A);
          }
        },
        kStencilBlock);
}

}  // namespace elastogen::fem
