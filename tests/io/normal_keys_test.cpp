// SPDX-License-Identifier: Apache-2.0
#include "io/normal_keys.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

/// Normals of two vertices that turn about z by the angles of the frames [rad].
Array<float> turning(const std::vector<double>& angles) {
  Array<float> normals(int64_t(angles.size()), 6);
  for (size_t t = 0; t < angles.size(); ++t) {
    const double a = angles[t];
    const double row[6] = {std::cos(a), std::sin(a), 0, -std::sin(a), std::cos(a), 0};
    std::copy_n(row, 6, normals.row(int64_t(t)));
  }
  return normals;
}

std::vector<int64_t> frames(int64_t first, int64_t last) {
  std::vector<int64_t> result(size_t(last - first + 1));
  std::iota(result.begin(), result.end(), first);
  return result;
}

/// Angle between a vertex's true normal and the one that a client shows: the normal at rest plus
/// weighted changes, scaled to length one [rad].
double shown_error(const Array<float>& normals, const NormalKeys& keys, const FrameRange& range,
                   int64_t t) {
  double n[3] = {normals(0, 0), normals(0, 1), normals(0, 2)}, square = 0, along = 0;
  for (size_t k = 0; k < keys.frames.size(); ++k)
    for (int d = 0; d < 3; ++d)
      n[d] += double(keys.weights(t - range.first, int(k))) *
              (double(normals(keys.frames[k], d)) - double(normals(0, d)));
  for (int d = 0; d < 3; ++d) {
    square += n[d] * n[d];
    along += n[d] * double(normals(t, d));
  }
  return std::acos(std::min(1.0, along / std::sqrt(square)));
}

TEST(NormalKeys, TwoKeysCarryAQuarterTurnWithTheErrorOfAChord) {
  // a chord of 90 degrees: halfway its direction is exact, at a fifth it lags
  std::vector<double> angles;
  for (int t = 0; t <= 10; ++t) angles.push_back(t * M_PI / 20);
  const Array<float> normals = turning(angles);
  const FrameRange range{0, 10};
  const NormalKeys keys = normal_keys(normals, range, frames(1, 10), 2, 1e-3);
  EXPECT_EQ(keys.frames.back(), 10);
  double worst = 0;
  for (int64_t t = 0; t <= 10; ++t) worst = std::max(worst, shown_error(normals, keys, range, t));
  EXPECT_NEAR(worst, keys.error, 1e-3);
}

TEST(NormalKeys, KeysAreAddedUntilTheToleranceIsMet) {
  std::vector<double> angles;
  for (int t = 0; t <= 60; ++t) angles.push_back(1.5 * std::sin(0.05 * t));
  const Array<float> normals = turning(angles);
  const FrameRange range{0, 60};
  const NormalKeys keys = normal_keys(normals, range, frames(1, 60), 60, 0.01);
  EXPECT_LE(keys.error, 0.01);
  EXPECT_LT(keys.frames.size(), 30u);
  for (int64_t t = 0; t <= 60; ++t) EXPECT_LE(shown_error(normals, keys, range, t), 0.0101);
}

TEST(NormalKeys, EveryFrameAKeyIsExact) {
  const Array<float> normals = turning({0, 0.4, -0.7, 1.1, 0.2});
  const FrameRange range{0, 4};
  const NormalKeys keys = normal_keys(normals, range, frames(1, 4), 4, 0);
  EXPECT_EQ(keys.frames, frames(1, 4));
  EXPECT_EQ(keys.error, 0);
  for (int64_t t = 0; t <= 4; ++t) EXPECT_LT(shown_error(normals, keys, range, t), 1e-3);
}

TEST(NormalKeys, WeightsOfNeighboursSumToOneAndStillFramesHaveNone) {
  const Array<float> normals = turning({0, 0.1, 0.2, 0, 0.3, 0.5, 0.6, 0.9});
  const FrameRange range{1, 7};
  const NormalKeys keys = normal_keys(normals, range, {1, 2, 4, 5, 6, 7}, 3, 1e-9);
  EXPECT_EQ(keys.frames.size(), 3u);
  for (int64_t t = 1; t <= 7; ++t) {
    double sum = 0;
    for (int k = 0; k < 3; ++k) sum += keys.weights(t - 1, k);
    if (t == 3) {
      EXPECT_EQ(sum, 0);
    }
    if (t == 1 || t == 7) {
      EXPECT_EQ(sum, 1);
    }
    EXPECT_LE(sum, 1 + 1e-6);
  }
}

TEST(NormalKeys, RefusesTooFewKeysAndFramesThatAreNotThere) {
  const Array<float> normals = turning({0, 1});
  EXPECT_ANY_THROW(normal_keys(normals, {0, 1}, {1}, 1));
  EXPECT_ANY_THROW(normal_keys(normals, {0, 2}, {1}, 4));
}

}  // namespace
}  // namespace elastogen
