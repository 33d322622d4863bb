// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/dependent_nodes.cuh"
#include "tests/support/on_card.hpp"

#include <random>

namespace elastogen::test {
namespace {

class DependentNodesOnCard : public OnCard {};

constexpr int32_t kNodes = 3000;

/// Every third node follows none to four of the others, a few parent nodes have many followers.
DependentNodes many_followers() {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> weight(-9, 1);
  std::vector<int32_t> nodes, begin = {0}, parents;
  std::vector<double> weights;
  for (int32_t n = 0; n < kNodes; n += 3) {
    nodes.push_back(n);
    for (uint32_t k = random() % 5; k > 0; --k) {
      const auto m = int32_t(random() % (k == 1 ? 20 : kNodes / 3));
      parents.push_back(3 * m + 1);
      weights.push_back(weight(random));
    }
    begin.push_back(int32_t(parents.size()));
  }
  return DependentNodes(nodes, begin, parents, weights);
}

template <class T>
std::vector<T> some_values() {
  std::mt19937 random(11);
  std::uniform_real_distribution<double> uniform(-1, 1);
  std::vector<T> values(3 * kNodes);
  for (T& value : values) value = T(uniform(random));
  return values;
}

template <class T>
std::vector<T> host_copy(const cuda::DeviceArray<T>& array) {
  std::vector<T> values(size_t(array.size()));
  array.download(values.data());
  return values;
}

template <class T>
void expect_bits_of_host() {
  const DependentNodes host = many_followers();
  const cuda::DeviceDependentNodes device(host);
  for (int pass = 0; pass < 2; ++pass) {
    std::vector<T> filled = some_values<T>(), folded = filled;
    cuda::DeviceArray<T> to_fill(filled), to_fold(folded);
    host.fill(filled.data());
    host.fold(folded.data());
    device.fill(to_fill.data());
    device.fold(to_fold.data());
    EXPECT_EQ(host_copy(to_fill), filled);
    EXPECT_EQ(host_copy(to_fold), folded);
  }
}

TEST_F(DependentNodesOnCard, FillAndFoldHaveTheBitsOfTheHost) {
  expect_bits_of_host<float>();
  expect_bits_of_host<double>();
}

TEST_F(DependentNodesOnCard, FoldIsTheTransposeOfFill) {
  const cuda::DeviceDependentNodes device(many_followers());
  std::vector<double> a = some_values<double>(), b(a.rbegin(), a.rend());
  for (size_t n = 0; n < size_t(kNodes); n += 3)
    for (size_t d = 0; d < 3; ++d) a[3 * n + d] = 0;  // a has the free values alone
  cuda::DeviceArray<double> filled(a), folded(b);
  device.fill(filled.data());
  device.fold(folded.data());
  const std::vector<double> Ca = host_copy(filled), Ctb = host_copy(folded);
  double left = 0, right = 0, size = 0;
  for (size_t k = 0; k < a.size(); ++k) {
    left += Ca[k] * b[k], right += a[k] * Ctb[k];
    size += std::abs(Ca[k] * b[k]);
  }
  EXPECT_NEAR(left, right, 1e-13 * size);
}

TEST_F(DependentNodesOnCard, WithoutAnyNothingIsTouched) {
  const cuda::DeviceDependentNodes none{DependentNodes()};
  none.fill(static_cast<double*>(nullptr));
  none.fill(static_cast<double*>(nullptr), nullptr);
  none.fold(static_cast<float*>(nullptr));
  EXPECT_EQ(none.sums().count, 0);
  cuda::synchronise();
}

}  // namespace
}  // namespace elastogen::test
