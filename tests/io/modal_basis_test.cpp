// SPDX-License-Identifier: Apache-2.0
#include "io/modal_basis.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace elastogen {
namespace {

/// A motion that is held in memory, (frames, 3 vertices).
struct Held {
  Array<float> d;
  Motion motion;

  Held(int64_t frames, int64_t vertices) : d(frames, int(3 * vertices)) {
    motion.frames = frames;
    motion.vertices = vertices;
    motion.read = [this](int64_t t, int64_t first, int64_t count, float* to) {
      std::copy_n(d.row(t) + 3 * first, 3 * count, to);
    };
  }
  Held(const Held&) = delete;

  /// d_t = sum_k amplitude_k cos(w_k t) shape_k, zero at the frames in `still`.
  void fill(const std::vector<double>& amplitude, std::vector<int64_t> still = {}) {
    std::mt19937 random(7);
    std::normal_distribution<double> normal;
    Array<double> shape(int64_t(amplitude.size()), d.cols());
    for (int64_t i = 0; i < shape.size(); ++i) shape.data()[i] = normal(random);
    for (int64_t t = 0; t < d.rows(); ++t) {
      if (std::find(still.begin(), still.end(), t) != still.end()) continue;
      for (int i = 0; i < d.cols(); ++i) {
        double sum = 0;
        for (size_t k = 0; k < amplitude.size(); ++k)
          sum += amplitude[k] * std::cos(0.37 * double(k + 1) * double(t) + double(k)) *
                 shape(int64_t(k), i);
        d(t, i) = float(sum);
      }
    }
  }
};

/// Largest vertex error of the first modes of a basis, from what a file would hold [m].
double true_error(const Held& held, const ModalBasis& basis, int modes) {
  const Array<float> shapes = mode_shapes(held.motion, basis);
  double worst = 0;
  for (int64_t t = 0; t < held.d.rows(); ++t) {
    for (int v = 0; v < held.d.cols() / 3; ++v) {
      double mesh[3] = {}, square = 0;
      for (int k = 0; k < modes; ++k) {
        for (int c = 0; c < 3; ++c) mesh[c] += double(basis.weights(t, k)) * shapes(k, 3 * v + c);
      }
      for (int r = 0; r < 3; ++r) {
        double e = held.d(t, 3 * v + r);
        for (int c = 0; c < 3; ++c) e -= held.motion.to_metres[size_t(3 * r + c)] * mesh[c];
        square += e * e;
      }
      worst = std::max(worst, std::sqrt(square));
    }
  }
  return worst;
}

TEST(ModalBasis, TwoModesCarryAMotionOfRankTwo) {
  Held held(40, 100);
  held.fill({1, 0.3});
  const ModalBasis basis = modal_basis(held.motion, 1e-5);
  EXPECT_EQ(basis.modes(), 2);
  EXPECT_LT(basis.max_error, 1e-5);
}

TEST(ModalBasis, UsesTheFewestModesThatMeetTheTolerance) {
  Held held(60, 500);
  std::vector<double> amplitude;
  for (int k = 0; k < 20; ++k) amplitude.push_back(std::pow(0.5, k));
  held.fill(amplitude);
  const double tolerance = 1e-2;
  const ModalBasis basis = modal_basis(held.motion, tolerance);
  EXPECT_LE(basis.max_error, tolerance);
  EXPECT_NEAR(true_error(held, basis, basis.modes()), basis.max_error, 1e-12);
  EXPECT_GT(true_error(held, basis, basis.modes() - 1), tolerance);
}

TEST(ModalBasis, StatesTheErrorThatSixtyFourModesLeave) {
  Held held(150, 80);
  held.fill(std::vector<double>(120, 1));
  const ModalBasis basis = modal_basis(held.motion, 1e-9);
  EXPECT_LE(basis.modes(), kMaxModes);
  EXPECT_GT(basis.max_error, 1e-3);
  EXPECT_NEAR(true_error(held, basis, basis.modes()), basis.max_error, 1e-12);
}

TEST(ModalBasis, MeasuresTheErrorInMetresThroughTheMap) {
  Held held(20, 30);
  held.fill({1, 0.1, 0.01});
  // sheared and mirrored, det = -6
  held.motion.to_metres = {2, 1, 0, 0, 3, 0, 0, 0, -1};
  held.motion.to_mesh = {0.5, -1.0 / 6, 0, 0, 1.0 / 3, 0, 0, 0, -1};
  const ModalBasis basis = modal_basis(held.motion, 0.2);
  EXPECT_LE(basis.max_error, 0.2);
  EXPECT_NEAR(true_error(held, basis, basis.modes()), basis.max_error, 1e-12);
}

TEST(ModalBasis, CountsWhatAMapWithoutInverseCannotShow) {
  Held held(5, 10);
  held.fill({1});
  held.motion.to_metres = held.motion.to_mesh = {1, 0, 0, 0, 1, 0, 0, 0, 0};
  double flat = 0;
  for (int64_t t = 0; t < 5; ++t) {
    for (int v = 0; v < 10; ++v) flat = std::max(flat, std::abs(double(held.d(t, 3 * v + 2))));
  }
  EXPECT_NEAR(modal_basis(held.motion, 1e-6).max_error, flat, 1e-6);
  EXPECT_NEAR(keyframe_basis(held.motion).max_error, flat, 1e-6);
}

TEST(ModalBasis, AStillFrameHasNoWeight) {
  Held held(12, 20);
  held.fill({1, 1, 1}, {0, 5});
  const ModalBasis basis = modal_basis(held.motion, 1e-6);
  for (const int64_t t : {0, 5}) {
    for (int k = 0; k < basis.modes(); ++k) EXPECT_EQ(basis.weights(t, k), 0.f);
  }
  Held still(3, 20);
  EXPECT_EQ(modal_basis(still.motion, 1e-6).modes(), 0);
  EXPECT_EQ(keyframe_basis(still.motion).modes(), 0);
}

TEST(ModalBasis, FitsFramesThatAreNoSnapshots) {
  Held held(700, 40);
  held.fill({1, 0.5, 0.2, 0.1}, {0});
  const ModalBasis basis = modal_basis(held.motion, 1e-5);
  EXPECT_EQ(basis.modes(), 4);
  EXPECT_EQ(basis.snapshots.size(), size_t(kMaxSnapshots));
  EXPECT_NEAR(true_error(held, basis, 4), basis.max_error, 1e-12);
}

TEST(ModalBasis, TakesMoreVerticesThanABlockHolds) {
  // 2^21 / 80 vertices make a block
  Held large(80, 40000);
  large.fill({1, 0.1});
  EXPECT_EQ(modal_basis(large.motion, 1e-4).modes(), 2);
  const ModalBasis basis = modal_basis(large.motion, 1e-4);
  EXPECT_NEAR(true_error(large, basis, 2), basis.max_error, 1e-12);
}

TEST(ModalBasis, KeyframesAreTheFrames) {
  Held held(6, 25);
  held.fill({1, 1, 1, 1, 1}, {0, 3});
  const ModalBasis basis = keyframe_basis(held.motion);
  ASSERT_EQ(basis.modes(), 4);
  EXPECT_EQ(basis.snapshots, (std::vector<int64_t>{1, 2, 4, 5}));
  const Array<float> shapes = mode_shapes(held.motion, basis);
  for (int k = 0; k < 4; ++k) {
    const int64_t frame = basis.snapshots[size_t(k)];
    EXPECT_TRUE(std::equal(shapes.row(k), shapes.row(k) + 75, held.d.row(frame)));
    for (int64_t t = 0; t < 6; ++t) EXPECT_EQ(basis.weights(t, k), t == frame ? 1.f : 0.f);
  }
  EXPECT_EQ(basis.max_error, 0);
}

}  // namespace
}  // namespace elastogen
