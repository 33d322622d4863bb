// SPDX-License-Identifier: Apache-2.0
#include "core/dependent_nodes.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <algorithm>

namespace elastogen {

DependentNodes::DependentNodes(std::vector<int32_t> nodes, std::vector<int32_t> begin,
                               std::vector<int32_t> parents, std::vector<double> weights)
    : nodes_(std::move(nodes)),
      begin_(std::move(begin)),
      parents_(std::move(parents)),
      weights_(std::move(weights)) {
  // the lists fit together
  ELASTOGEN_CHECK(begin_.size() == nodes_.size() + 1 && parents_.size() == weights_.size() &&
                      begin_.front() == 0 && begin_.back() == int32_t(parents_.size()) &&
                      std::is_sorted(begin_.begin(), begin_.end()),
                  "the lists of dependent nodes do not fit together");
  ELASTOGEN_CHECK(std::is_sorted(nodes_.begin(), nodes_.end()), "dependent nodes must ascend");
  for (const int32_t m : parents_)
    ELASTOGEN_CHECK(m >= 0 && !std::binary_search(nodes_.begin(), nodes_.end(), m), "node ", m,
                    " is a parent node and must not depend on others");
  if (!nodes_.empty()) last_node_ = nodes_.back();
  for (const int32_t m : parents_) last_node_ = std::max(last_node_, m);
  // the transposed lists, dependent nodes in order
  all_parents_ = parents_;
  std::ranges::sort(all_parents_);
  all_parents_.erase(std::unique(all_parents_.begin(), all_parents_.end()), all_parents_.end());
  std::vector<std::vector<std::pair<int32_t, double>>> of(all_parents_.size());
  for (int64_t i = 0; i < count(); ++i)
    for (int32_t k = begin_[size_t(i)]; k < begin_[size_t(i + 1)]; ++k) {
      const auto place = std::ranges::lower_bound(all_parents_, parents_[size_t(k)]);
      of[size_t(place - all_parents_.begin())].push_back({nodes_[size_t(i)], weights_[size_t(k)]});
    }
  first_ = {0};
  for (const auto& list : of) {
    for (const auto& [child, weight] : list)
      children_.push_back(child), child_weights_.push_back(weight);
    first_.push_back(int32_t(children_.size()));
  }
}

template <class T>
void DependentNodes::fill(T* values) const {
  for_each(count(), [&](int64_t i) {
    double sum[3] = {};
    for (int32_t k = begin_[size_t(i)]; k < begin_[size_t(i + 1)]; ++k)
      for (int d = 0; d < 3; ++d)
        sum[d] += weights_[size_t(k)] * double(values[3 * int64_t(parents_[size_t(k)]) + d]);
    for (int d = 0; d < 3; ++d) values[3 * int64_t(nodes_[size_t(i)]) + d] = T(sum[d]);
  });
}

template <class T>
void DependentNodes::fold(T* gradient) const {
  for_each(int64_t(all_parents_.size()), [&](int64_t m) {
    T* const of_parent = gradient + 3 * int64_t(all_parents_[size_t(m)]);
    double sum[3] = {double(of_parent[0]), double(of_parent[1]), double(of_parent[2])};
    for (int32_t k = first_[size_t(m)]; k < first_[size_t(m + 1)]; ++k)
      for (int d = 0; d < 3; ++d)
        sum[d] +=
            child_weights_[size_t(k)] * double(gradient[3 * int64_t(children_[size_t(k)]) + d]);
    for (int d = 0; d < 3; ++d) of_parent[d] = T(sum[d]);
  });
  for (const int32_t i : nodes_) std::fill_n(gradient + 3 * int64_t(i), 3, T(0));
}

template void DependentNodes::fill(float*) const;
template void DependentNodes::fill(double*) const;
template void DependentNodes::fold(float*) const;
template void DependentNodes::fold(double*) const;

}  // namespace elastogen
