// SPDX-License-Identifier: Apache-2.0
// Sums over groups of items on the device, such as the nodes of each piece, in a fixed order.

#pragma once

#include "core/cuda/reduce.cuh"

#include <algorithm>

namespace elastogen::cuda {

/// A range of entries in the list of all groups' items; all of them belong to one group.
struct GroupChunk {
  int32_t group, begin, end;
};

/// The tables of the groups, as kernels read them.
struct GroupsView {
  const int32_t *items, *chunk_begin, *first;
  const GroupChunk* chunks;
};

namespace groups {

inline constexpr int32_t kChunk = 1024;  // entries

/// Calls body(group, item) for every entry, one block for each chunk.
template <class Body>
__global__ void __launch_bounds__(kSumThreads) entries_kernel(GroupsView g, Body body) {
  const GroupChunk chunk = g.chunks[blockIdx.x];
  for (int k = chunk.begin + int(threadIdx.x); k < chunk.end; k += kSumThreads)
    body(int64_t(chunk.group), int64_t(g.items[k]));
}

/// partial[chunk] = sum of body(group, item, sum) over the entries of a chunk, one block for each.
template <class Sum, class Body>
__global__ void __launch_bounds__(kSumThreads) chunk_kernel(GroupsView g, Sum* partial, Body body) {
  alignas(Sum) __shared__ unsigned char all[kSumWarps * sizeof(Sum)];
  const GroupChunk chunk = g.chunks[blockIdx.x];
  Sum mine;
  for (int k = chunk.begin + int(threadIdx.x); k < chunk.end; k += kSumThreads)
    body(int64_t(chunk.group), int64_t(g.items[k]), mine);
  const Sum sum = block_sum(mine, reinterpret_cast<Sum*>(all));
  if (threadIdx.x == 0) partial[blockIdx.x] = sum;
}

/// Calls then(group, sum of its chunks), one block for each group.
template <class Sum, class Then>
__global__ void __launch_bounds__(kSumThreads)
    group_kernel(GroupsView g, const Sum* partial, Then then) {
  alignas(Sum) __shared__ unsigned char all[kSumWarps * sizeof(Sum)];
  const int64_t p = blockIdx.x;
  const int64_t first = g.chunk_begin[p], count = g.chunk_begin[p + 1] - first;
  const Sum sum = detail::sum_of_partials(
      count, [&](int64_t k) { return partial[first + k]; }, reinterpret_cast<Sum*>(all));
  if (threadIdx.x == 0) then(p, sum);
}

}  // namespace groups

class DeviceGroups {
 public:
  /// @param lists  items of each group; one may be empty.
  explicit DeviceGroups(const std::vector<std::vector<int32_t>>& lists) {
    std::vector<int32_t> chunk_begin, first, items;
    std::vector<GroupChunk> chunks;
    for (const std::vector<int32_t>& list : lists) {
      const auto group = int32_t(first.size());
      first.push_back(list.empty() ? -1 : list.front());
      chunk_begin.push_back(int32_t(chunks.size()));
      auto begin = int32_t(items.size());
      items.insert(items.end(), list.begin(), list.end());
      for (const auto end = int32_t(items.size()); begin < end; begin = chunks.back().end)
        chunks.push_back({group, begin, std::min(begin + groups::kChunk, end)});
    }
    chunk_begin.push_back(int32_t(chunks.size()));
    items_ = DeviceArray<int32_t>(items);
    chunks_ = DeviceArray<GroupChunk>(chunks);
    chunk_begin_ = DeviceArray<int32_t>(chunk_begin);
    first_ = DeviceArray<int32_t>(first);
  }

  int64_t count() const { return first_.size(); }
  int64_t chunks() const { return chunks_.size(); }  ///< partial sums that sums() needs
  GroupsView view() const {
    return {items_.data(), chunk_begin_.data(), first_.data(), chunks_.data()};
  }

  /// Calls body(group, item) for every item.
  template <class Body>
  void for_each(const Body& body) const {
    if (chunks() == 0) return;
    groups::entries_kernel<<<unsigned(chunks()), kSumThreads, 0, cudaStreamPerThread>>>(view(),
                                                                                        body);
    check(cudaGetLastError());
  }

  /// Adds body(group, item, sum) over the items of each group, then calls then(group, sum).
  template <class Sum, class Body, class Then>
  void sums(DeviceArray<Sum>& partial, const Body& body, const Then& then) const {
    if (count() == 0) return;
    if (chunks() > 0)
      groups::chunk_kernel<<<unsigned(chunks()), kSumThreads, 0, cudaStreamPerThread>>>(
          view(), partial.data(), body);
    check(cudaGetLastError());
    groups::group_kernel<<<unsigned(count()), kSumThreads, 0, cudaStreamPerThread>>>(
        view(), partial.data(), then);
    check(cudaGetLastError());
  }

 private:
  DeviceArray<int32_t> items_;        // of all groups, one after the other
  DeviceArray<GroupChunk> chunks_;    // in the order of the groups
  DeviceArray<int32_t> chunk_begin_;  // first chunk of each group, (groups + 1)
  DeviceArray<int32_t> first_;        // first item of each group, -1: none
};

}  // namespace elastogen::cuda
