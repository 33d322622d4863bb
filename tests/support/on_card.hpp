// SPDX-License-Identifier: Apache-2.0
// The fixture that skips where there is no card.

#pragma once

#include "core/cuda/card.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {

class OnCard : public testing::Test {
 protected:
  void SetUp() override {
    if (!cuda::has_device()) GTEST_SKIP() << "there is no CUDA device here";
  }
};

}  // namespace elastogen::test
