// SPDX-License-Identifier: Apache-2.0
// Whole numbers for tests of sorts and sums.

#pragma once

#include <cstdint>
#include <random>
#include <vector>

namespace elastogen::test {

/// Numbers with this many bits, equal in every run; with few bits many of them are equal.
template <class Key>
std::vector<Key> random_keys(int64_t count, int bits) {
  std::mt19937_64 random(5);
  std::vector<Key> keys(static_cast<size_t>(count));
  for (Key& key : keys) key = Key(random() >> (64 - bits));
  return keys;
}

}  // namespace elastogen::test
