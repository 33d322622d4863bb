// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/solve/coarse_space.hpp"

#include "core/parallel.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

constexpr int kMotions = 6;         // of a group: three translations, three rotations
constexpr double kShift = 1e-10;    // of the diagonal, for groups that cannot move in all six ways
constexpr int64_t kGroupBlock = 8;  // groups of a task

/// Calls use(node) for the neighbours of a node, itself included.
template <class Use>
void for_neighbours(const SparseMatrix& pattern, int64_t node, const Use& use) {
  for (int32_t k = pattern.start[size_t(3 * node)]; k < pattern.start[size_t(3 * node) + 1]; k += 3)
    use(pattern.column[size_t(k)] / 3);
}

}  // namespace

CoarseSpace::CoarseSpace(const SparseMatrix& pattern, In<double> positions, const uint8_t* fixed) {
  make_groups(pattern);
  const int64_t nodes = positions.rows;
  std::vector<double> centre(size_t(3 * groups()));
  for (int64_t g = 0; g < groups(); ++g)
    for (int32_t k = first_[size_t(g)]; k < first_[size_t(g) + 1]; ++k)
      for (int d = 0; d < 3; ++d)
        centre[size_t(3 * g + d)] +=
            positions(members_[size_t(k)], d) / (first_[size_t(g) + 1] - first_[size_t(g)]);
  motions_.resize(size_t(18 * nodes));
  for (int64_t n = 0; n < nodes; ++n)
    for (int i = 0; i < 3; ++i) {
      if (fixed[3 * n + i]) continue;
      double* row = motions_.data() + 18 * n + 6 * i;
      const int j = (i + 1) % 3, k = (i + 2) % 3;
      const double* c = centre.data() + 3 * group_[size_t(n)];
      // u_i = (omega x (X - c))_i
      row[i] = 1;
      row[3 + j] = positions(n, k) - c[k];
      row[3 + k] = c[j] - positions(n, j);
    }
  make_pattern(pattern);
  right_.resize(size_t(kMotions * groups()));
  direct_ = std::make_unique<SparseDirect>(matrix_);
}

/// A node forms a group with all its neighbours if none of them has one yet; the others join the
/// group of the first neighbour that has one.
void CoarseSpace::make_groups(const SparseMatrix& pattern) {
  const int64_t nodes = pattern.rows() / 3;
  group_.assign(size_t(nodes), -1);
  int32_t count = 0;
  // groups of a node with all its neighbours
  for (int64_t n = 0; n < nodes; ++n) {
    bool untouched = true;
    for_neighbours(pattern, n, [&](int32_t m) { untouched &= group_[size_t(m)] < 0; });
    if (!untouched) continue;
    for_neighbours(pattern, n, [&](int32_t m) { group_[size_t(m)] = count; });
    ++count;
  }
  // other nodes join a group of a neighbour
  std::vector<int32_t> joined = group_;
  for (int64_t n = 0; n < nodes; ++n)
    if (group_[size_t(n)] < 0)
      for_neighbours(pattern, n, [&](int32_t m) {
        if (joined[size_t(n)] < 0) joined[size_t(n)] = group_[size_t(m)];
      });
  group_ = std::move(joined);
  // members of each group
  first_.assign(size_t(count) + 1, 0);
  for (const int32_t g : group_) ++first_[size_t(g) + 1];
  for (size_t g = 0; g < size_t(count); ++g) first_[g + 1] += first_[g];
  members_.resize(size_t(nodes));
  std::vector<int32_t> next(first_.begin(), first_.end() - 1);
  for (int64_t n = 0; n < nodes; ++n)
    members_[size_t(next[size_t(group_[size_t(n)])]++)] = int32_t(n);
}

void CoarseSpace::make_pattern(const SparseMatrix& pattern) {
  std::vector<std::vector<int32_t>> neighbours(static_cast<size_t>(groups()));
  for_each(
      groups(),
      [&](int64_t g) {
        std::vector<int32_t>& list = neighbours[size_t(g)];
        for (int32_t k = first_[size_t(g)]; k < first_[size_t(g) + 1]; ++k)
          for_neighbours(pattern, members_[size_t(k)],
                         [&](int32_t m) { list.push_back(group_[size_t(m)]); });
        std::sort(list.begin(), list.end());
        list.erase(std::unique(list.begin(), list.end()), list.end());
      },
      kGroupBlock);
  matrix_.start.push_back(0);
  for (const std::vector<int32_t>& list : neighbours)
    for (int a = 0; a < kMotions; ++a) {
      for (const int32_t h : list)
        for (int b = 0; b < kMotions; ++b) matrix_.column.push_back(kMotions * h + b);
      matrix_.start.push_back(int32_t(matrix_.column.size()));
    }
  matrix_.value.resize(matrix_.column.size());
}

/// Adds P_n^T A_nm P_m of a node n and its neighbours m to the rows of its group.
void CoarseSpace::add_node(const SparseMatrix& A, int64_t n) {
  const int64_t row = kMotions * int64_t(group_[size_t(n)]);
  const int32_t begin = matrix_.start[size_t(row)];
  const int32_t width = matrix_.start[size_t(row) + 1] - begin;
  const int32_t* columns = matrix_.column.data() + begin;
  const double* P_n = motions_.data() + 18 * n;
  const int32_t first = A.start[size_t(3 * n)], last = A.start[size_t(3 * n) + 1];
  for (int32_t k = 0; k < last - first; k += 3) {
    const int32_t m = A.column[size_t(first + k)] / 3;
    const double* P_m = motions_.data() + 18 * int64_t(m);
    double AP[3][kMotions] = {};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) {
        const double a = A.value[size_t(A.start[size_t(3 * n + i)] + k + j)];
        for (int b = 0; b < kMotions; ++b) AP[i][b] += a * P_m[6 * j + b];
      }
    const int32_t column = kMotions * group_[size_t(m)];
    const auto place = std::lower_bound(columns, columns + width, column) - columns;
    double* to = matrix_.value.data() + begin + place;
    for (int a = 0; a < kMotions; ++a)
      for (int i = 0; i < 3; ++i)
        for (int b = 0; b < kMotions; ++b) to[a * width + b] += P_n[6 * i + a] * AP[i][b];
  }
}

bool CoarseSpace::factor(const SparseMatrix& A) {
  std::fill(matrix_.value.begin(), matrix_.value.end(), 0.0);
  for_each(
      groups(),
      [&](int64_t g) {
        for (int32_t k = first_[size_t(g)]; k < first_[size_t(g) + 1]; ++k)
          add_node(A, members_[size_t(k)]);
      },
      kGroupBlock);
  const std::vector<double> d = diagonal(matrix_);
  for (int64_t r = 0; r < matrix_.rows(); ++r)
    matrix_.at(r, r) = d[size_t(r)] > 0 ? d[size_t(r)] * (1 + kShift) : 1;
  return direct_->factor(matrix_);
}

void CoarseSpace::add_correction(const double* r, double* z) {
  for_each(
      groups(),
      [&](int64_t g) {
        double sum[kMotions] = {};
        for (int32_t k = first_[size_t(g)]; k < first_[size_t(g) + 1]; ++k) {
          const int64_t n = members_[size_t(k)];
          for (int i = 0; i < 3; ++i)
            for (int a = 0; a < kMotions; ++a)
              sum[a] += motions_[size_t(18 * n + 6 * i + a)] * r[3 * n + i];
        }
        std::copy(sum, sum + kMotions, right_.data() + kMotions * g);
      },
      kGroupBlock);
  direct_->solve(right_.data(), right_.data());
  for_each(int64_t(group_.size()), [&](int64_t n) {
    const double* y = right_.data() + kMotions * group_[size_t(n)];
    for (int i = 0; i < 3; ++i)
      for (int a = 0; a < kMotions; ++a)
        z[3 * n + i] += motions_[size_t(18 * n + 6 * i + a)] * y[a];
  });
}

}  // namespace elastogen::fem
