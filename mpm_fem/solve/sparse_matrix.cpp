// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/sparse_matrix.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <algorithm>
#include <limits>

namespace elastogen::fem {
namespace {

constexpr int64_t kElementBlock = 32;  // elements of a task
constexpr int64_t kMaxCorners = 10;

int64_t place_of(const SparseMatrix& A, int64_t row, int64_t col) {
  const auto first = A.column.begin() + A.start[size_t(row)];
  const auto last = A.column.begin() + A.start[size_t(row) + 1];
  const auto found = std::lower_bound(first, last, int32_t(col));
  ELASTOGEN_CHECK(found != last && *found == col, "the matrix has no entry (", row, ", ", col, ")");
  return found - A.column.begin();
}

/// Elements around each node: those of node n are list[start[n] .. start[n+1]).
struct ElementsOfNodes {
  std::vector<int64_t> start;
  std::vector<int32_t> list;
};

ElementsOfNodes elements_of_nodes(In<int32_t> elements, int64_t nodes) {
  ElementsOfNodes result;
  result.start.resize(size_t(nodes) + 1);
  for (int64_t k = 0; k < elements.size(); ++k) ++result.start[size_t(elements.data[k]) + 1];
  for (size_t n = 0; n < size_t(nodes); ++n) result.start[n + 1] += result.start[n];
  result.list.resize(size_t(elements.size()));
  std::vector<int64_t> next(result.start.begin(), result.start.end() - 1);
  for (int64_t k = 0; k < elements.size(); ++k)
    result.list[size_t(next[size_t(elements.data[k])]++)] = int32_t(k / elements.cols);
  return result;
}

}  // namespace

double& SparseMatrix::at(int64_t row, int64_t col) {
  return value[size_t(place_of(*this, row, col))];
}

double SparseMatrix::at(int64_t row, int64_t col) const {
  return value[size_t(place_of(*this, row, col))];
}

void multiply(const SparseMatrix& A, const double* x, double* y) {
  for_each(A.rows(), [&](int64_t r) {
    double sum = 0;
    for (int32_t k = A.start[size_t(r)]; k < A.start[size_t(r) + 1]; ++k)
      sum += A.value[size_t(k)] * x[A.column[size_t(k)]];
    y[r] = sum;
  });
}

std::vector<double> diagonal(const SparseMatrix& A) {
  std::vector<double> result(size_t(A.rows()));
  for_each(A.rows(), [&](int64_t r) { result[size_t(r)] = A.at(r, r); });
  return result;
}

void fix_unknowns(const uint8_t* fixed, SparseMatrix& A, double* b) {
  for_each(A.rows(), [&](int64_t r) {
    double moved = 0;
    for (int32_t k = A.start[size_t(r)]; k < A.start[size_t(r) + 1]; ++k) {
      const int32_t c = A.column[size_t(k)];
      if (!fixed[r] && !fixed[c]) continue;
      if (!fixed[r] && b) moved += A.value[size_t(k)] * b[c];
      A.value[size_t(k)] = r == c ? 1 : 0;
    }
    if (!fixed[r] && b) b[r] -= moved;
  });
}

SparseMatrix free_part(const uint8_t* fixed, const SparseMatrix& A) {
  std::vector<int32_t> number(size_t(A.rows()));
  int32_t count = 0;
  for (int64_t r = 0; r < A.rows(); ++r) number[size_t(r)] = fixed[r] ? -1 : count++;
  SparseMatrix part;
  part.start.push_back(0);
  for (int64_t r = 0; r < A.rows(); ++r) {
    if (fixed[r]) continue;
    for (int32_t k = A.start[size_t(r)]; k < A.start[size_t(r) + 1]; ++k) {
      const int32_t c = number[size_t(A.column[size_t(k)])];
      if (c < 0) continue;
      part.column.push_back(c);
      part.value.push_back(A.value[size_t(k)]);
    }
    part.start.push_back(int32_t(part.column.size()));
  }
  return part;
}

Assembly::Assembly(In<int32_t> elements, int64_t nodes)
    : corners_(elements.cols), nodes_(elements.data, elements.data + elements.size()) {
  ELASTOGEN_CHECK(elements.cols <= kMaxCorners, "elements must have at most ", kMaxCorners,
                  " nodes, got ", elements);
  make_pattern(elements, nodes);
  make_colours(elements, nodes);
}

void Assembly::make_pattern(In<int32_t> elements, int64_t nodes) {
  const ElementsOfNodes around = elements_of_nodes(elements, nodes);
  // neighbours of each node, itself included: first their number, then they
  std::vector<std::vector<int32_t>> neighbours(static_cast<size_t>(nodes));
  for_each(nodes, [&](int64_t n) {
    std::vector<int32_t>& list = neighbours[size_t(n)];
    list.push_back(int32_t(n));
    for (int64_t k = around.start[size_t(n)]; k < around.start[size_t(n) + 1]; ++k) {
      const int32_t* row = elements.row(around.list[size_t(k)]);
      list.insert(list.end(), row, row + elements.cols);
    }
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  });
  int64_t entries = 0;
  for (const std::vector<int32_t>& list : neighbours) entries += 9 * int64_t(list.size());
  ELASTOGEN_CHECK(entries <= std::numeric_limits<int32_t>::max(), "a matrix of ", nodes,
                  " nodes has ", entries, " entries, more than 2^31 - 1");
  pattern_.start.push_back(0);
  pattern_.column.reserve(size_t(entries));
  for (int64_t n = 0; n < nodes; ++n)
    for (int i = 0; i < 3; ++i) {
      for (const int32_t m : neighbours[size_t(n)])
        for (int j = 0; j < 3; ++j) pattern_.column.push_back(3 * m + j);
      pattern_.start.push_back(int32_t(pattern_.column.size()));
    }
  pattern_.value.resize(pattern_.column.size());

  const int64_t n2 = int64_t(corners_) * corners_;
  place_.resize(size_t(elements.rows * n2));
  for_each(elements.rows, [&](int64_t e) {
    for (int a = 0; a < corners_; ++a)
      for (int b = 0; b < corners_; ++b) {
        const std::vector<int32_t>& list = neighbours[size_t(elements(e, a))];
        const auto found = std::lower_bound(list.begin(), list.end(), elements(e, b));
        place_[size_t(e * n2 + a * corners_ + b)] = 3 * int32_t(found - list.begin());
      }
  });
}

void Assembly::make_colours(In<int32_t> elements, int64_t nodes) {
  const ElementsOfNodes around = elements_of_nodes(elements, nodes);
  std::vector<int32_t> colour(size_t(elements.rows), -1);
  std::vector<int64_t> taken;  // last element that saw a colour on a neighbour
  std::vector<int64_t> count;
  for (int64_t e = 0; e < elements.rows; ++e) {
    for (int a = 0; a < corners_; ++a) {
      const size_t n = size_t(elements(e, a));
      for (int64_t k = around.start[n]; k < around.start[n + 1]; ++k)
        if (const int32_t c = colour[size_t(around.list[size_t(k)])]; c >= 0) taken[size_t(c)] = e;
    }
    size_t c = 0;
    while (c < taken.size() && taken[c] == e) ++c;
    if (c == taken.size()) taken.push_back(-1), count.push_back(0);
    colour[size_t(e)] = int32_t(c);
    ++count[c];
  }
  colours_.assign(1, 0);
  for (const int64_t k : count) colours_.push_back(colours_.back() + k);
  by_colour_.resize(size_t(elements.rows));
  std::vector<int64_t> next(colours_.begin(), colours_.end() - 1);
  for (int64_t e = 0; e < elements.rows; ++e)
    by_colour_[size_t(next[size_t(colour[size_t(e)])]++)] = int32_t(e);
}

void Assembly::add(const ElementMatrix& element_matrix, SparseMatrix& A) const {
  ELASTOGEN_CHECK(A.start.size() == pattern_.start.size() && A.entries() == pattern_.entries(),
                  "the matrix must have the pattern of the assembly");
  const int width = 3 * corners_;
  for (size_t c = 0; c + 1 < colours_.size(); ++c)
    for_each(
        colours_[c + 1] - colours_[c],
        [&](int64_t k) {
          const int64_t e = by_colour_[size_t(colours_[c] + k)];
          double K[9 * kMaxCorners * kMaxCorners];
          element_matrix(e, K);
          const int32_t* place = place_.data() + e * corners_ * corners_;
          for (int a = 0; a < corners_; ++a)
            for (int i = 0; i < 3; ++i) {
              const size_t row = size_t(3 * int64_t(nodes_[size_t(e * corners_ + a)]) + i);
              double* values = A.value.data() + A.start[row];
              const double* from = K + (3 * a + i) * width;
              for (int b = 0; b < corners_; ++b)
                for (int j = 0; j < 3; ++j) values[place[a * corners_ + b] + j] += from[3 * b + j];
            }
        },
        kElementBlock);
}

}  // namespace elastogen::fem
