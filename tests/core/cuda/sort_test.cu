// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/sort.cuh"
#include "core/error.hpp"
#include "core/parallel_sort.hpp"
#include "core/scan.hpp"
#include "tests/core/random_keys.hpp"
#include "tests/support/on_card.hpp"

namespace elastogen::test {
namespace {

using cuda::DeviceArray;

template <class T>
std::vector<T> fetch(const DeviceArray<T>& from) {
  std::vector<T> to(size_t(from.size()));
  from.download(to.data());
  return to;
}

class DeviceSort : public OnCard {};

template <class Key>
void expect_sorted(int64_t n, int bits) {
  const std::vector<Key> keys = random_keys<Key>(n, bits);
  std::vector<Key> expected(keys.size());
  std::vector<int32_t> order(keys.size());
  sort_with_order(keys.data(), n, expected.data(), order.data());
  const DeviceArray<Key> on_device(keys);
  cuda::SortWork work(n + 7);
  for (const int of_bits : {bits, 8 * int(sizeof(Key))}) {
    DeviceArray<Key> sorted(n);
    DeviceArray<int32_t> found(n);
    cuda::sort_with_order(on_device.data(), n, sorted.data(), found.data(), work, of_bits);
    EXPECT_EQ(fetch(sorted), expected);
    EXPECT_EQ(fetch(found), order);
  }
  EXPECT_EQ(fetch(on_device), keys);
}

TEST_F(DeviceSort, OrderIsThatOfTheHost) {
  for (const int64_t n : {1, 31, 1000, 300000}) {
    expect_sorted<uint32_t>(n, 3);
    expect_sorted<uint32_t>(n, 32);
    expect_sorted<uint64_t>(n, 10);
    expect_sorted<uint64_t>(n, 54);
  }
}

template <class T>
void expect_summed(int64_t n, int bits) {
  const std::vector<uint32_t> keys = random_keys<uint32_t>(n, bits);
  const std::vector<T> values(keys.begin(), keys.end());
  std::vector<T> expected(values.size() + 1);
  exclusive_sum(values.data(), n, expected.data());
  const DeviceArray<T> on_device(values);
  DeviceArray<T> sums(n + 1);
  cuda::SortWork work(n);
  cuda::exclusive_sum(on_device.data(), n, sums.data(), work);
  EXPECT_EQ(fetch(sums), expected);
}

TEST_F(DeviceSort, SumsAreThoseOfTheHost) {
  for (const int64_t n : {1, 255, 300001}) {
    expect_summed<int32_t>(n, 8);
    expect_summed<int64_t>(n, 32);
  }
}

TEST_F(DeviceSort, TakesNoNumbers) {
  cuda::SortWork work(0);
  cuda::sort_with_order<uint32_t>(nullptr, 0, nullptr, nullptr, work);
  DeviceArray<int32_t> sums(std::vector<int32_t>{9});
  cuda::exclusive_sum<int32_t>(nullptr, 0, sums.data(), work);
  EXPECT_EQ(fetch(sums), std::vector<int32_t>{0});
}

TEST_F(DeviceSort, RefusesMoreThanItsCapacity) {
  cuda::SortWork work(4);
  DeviceArray<uint32_t> keys(5), sorted(5);
  DeviceArray<int32_t> order(5), sums(6);
  EXPECT_THROW(cuda::sort_with_order(keys.data(), 5, sorted.data(), order.data(), work), Error);
  EXPECT_THROW(cuda::exclusive_sum(order.data(), 5, sums.data(), work), Error);
}

}  // namespace
}  // namespace elastogen::test
