// SPDX-License-Identifier: Apache-2.0
#include "io/own_columns.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

TEST(OwnColumns, GiveBackTheValuesOfEveryType) {
  OwnColumns own;
  const double value[2][8] = {{-128, 255, -32768, 65535, -2147483648.0, 4294967295.0, 0.25, 0.1},
                              {127, 0, 1, 2, 3, 4, -1e30f, -1e300}};
  for (int k = 0; k < 8; ++k) own.columns.push_back({"c", PlyType(k)});
  for (const auto& row : value)
    for (size_t k = 0; k < 8; ++k) own.add(k, row[k]);
  for (size_t p = 0; p < 2; ++p)
    for (size_t k = 0; k < 8; ++k) EXPECT_EQ(own.value(p, k), value[p][k]) << k;
}

}  // namespace
}  // namespace elastogen
