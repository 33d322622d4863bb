// SPDX-License-Identifier: Apache-2.0
// The one source that includes CUB.
#include "core/cuda/sort.cuh"

#include <cub/device/device_radix_sort.cuh>
#include <cub/device/device_scan.cuh>

#include <algorithm>

namespace elastogen::cuda {
namespace {

template <class Key>
cudaError_t run_sort(void* temporary, size_t& bytes, const Key* keys, Key* sorted,
                     const int32_t* places, int32_t* order, int64_t n, int bits) {
  return cub::DeviceRadixSort::SortPairs(temporary, bytes, keys, sorted, places, order, int(n), 0,
                                         bits, cudaStreamPerThread);
}

template <class T>
cudaError_t run_sum(void* temporary, size_t& bytes, const T* values, T* sums, int64_t n) {
  return cub::DeviceScan::InclusiveSum(temporary, bytes, values, sums, int(n), cudaStreamPerThread);
}

template <class Key>
size_t bytes_of_sort(int64_t n) {
  size_t bytes = 0;
  check(run_sort<Key>(nullptr, bytes, nullptr, nullptr, nullptr, nullptr, n, 8 * sizeof(Key)));
  return bytes;
}

template <class T>
size_t bytes_of_sum(int64_t n) {
  size_t bytes = 0;
  check(run_sum<T>(nullptr, bytes, nullptr, nullptr, n));
  return bytes;
}

void number(int32_t* places, int64_t n) {
  for_each(n, [=] __device__(int64_t k) { places[k] = int32_t(k); });
}

void check_count(int64_t n, const SortWork& work) {
  ELASTOGEN_CHECK(n >= 0 && n <= work.capacity(), "at most ", work.capacity(),
                  " numbers are expected, got ", n);
}

}  // namespace

SortWork::SortWork(int64_t capacity)
    : places_(capacity),
      temporary_(
          int64_t(std::max({bytes_of_sort<uint32_t>(capacity), bytes_of_sort<uint64_t>(capacity),
                            bytes_of_sum<int32_t>(capacity), bytes_of_sum<int64_t>(capacity)}))) {
  if (places_.data()) number(places_.data(), capacity);
}

template <class Key>
void sort_with_order(const Key* keys, int64_t n, Key* sorted, int32_t* order, SortWork& work,
                     int bits) {
  check_count(n, work);
  if (n == 0) return;
  auto bytes = size_t(work.temporary().size());
  check(run_sort(work.temporary().data(), bytes, keys, sorted, work.places(), order, n, bits));
}

template <class T>
void exclusive_sum(const T* values, int64_t n, T* sums, SortWork& work) {
  check_count(n, work);
  check(cudaMemsetAsync(sums, 0, sizeof(T), cudaStreamPerThread));
  if (n == 0) return;
  auto bytes = size_t(work.temporary().size());
  check(run_sum(work.temporary().data(), bytes, values, sums + 1, n));
}

template void sort_with_order(const uint32_t*, int64_t, uint32_t*, int32_t*, SortWork&, int);
template void sort_with_order(const uint64_t*, int64_t, uint64_t*, int32_t*, SortWork&, int);
template void exclusive_sum(const int32_t*, int64_t, int32_t*, SortWork&);
template void exclusive_sum(const int64_t*, int64_t, int64_t*, SortWork&);

}  // namespace elastogen::cuda
