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
    motion.parts = {{.vertices = vertices}};
    motion.read = [this](int64_t t, int64_t first, int64_t count, float* to) {
      std::copy_n(d.row(t) + 3 * first, 3 * count, to);
    };
  }
  Held(const Held&) = delete;
  FrameRange all() const { return {0, d.rows() - 1}; }

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

/// Largest vertex error of a basis for a range of frames, from the numbers of a file [m].
double true_error(const Held& held, const ModalBasis& basis, const FrameRange& frames) {
  const MotionPart& part = held.motion.parts[0];
  const Array<float> shapes = target_shapes(held.motion, part, basis);
  double worst = 0;
  for (int64_t t = frames.first; t <= frames.last; ++t) {
    for (int v = 0; v < held.d.cols() / 3; ++v) {
      double mesh[3] = {}, square = 0;
      for (int k = 0; k < basis.targets(); ++k) {
        const double weight = basis.weights(t - frames.first, k);
        for (int c = 0; c < 3; ++c) mesh[c] += weight * shapes(k, 3 * v + c);
      }
      for (int r = 0; r < 3; ++r) {
        double e = held.d(t, 3 * v + r);
        for (int c = 0; c < 3; ++c) e -= part.to_metres[size_t(3 * r + c)] * mesh[c];
        square += e * e;
      }
      worst = std::max(worst, std::sqrt(square));
    }
  }
  return worst;
}

double true_error(const Held& held, const ModalBasis& basis) {
  return true_error(held, basis, held.all());
}

ModalBasis modes(const Held& held, double tolerance, int most = 64) {
  return modal_basis(held.motion, held.all(), tolerance, most);
}

TEST(ModalBasis, AMotionOfRankTwoTakesTwoModesAndTheMean) {
  Held held(40, 100);
  held.fill({1, 0.3});
  const ModalBasis basis = modes(held, 1e-5);
  EXPECT_EQ(basis.targets(), 3);  // the weights of both change sign
  EXPECT_LT(basis.max_error, 1e-5);
}

TEST(ModalBasis, WeightsStayWithinZeroAndOneAndReachBoth) {
  Held held(60, 50);
  held.fill({1, 0.5, 0.2, 0.1, 0.05}, {0});
  const ModalBasis basis = modes(held, 1e-4);
  ASSERT_GE(basis.targets(), 4);
  for (int k = 1; k < basis.targets(); ++k) {
    float least = 1, largest = 0;
    for (int64_t t = 1; t < 60; ++t) {
      EXPECT_GE(basis.weights(t, k), 0);
      EXPECT_LE(basis.weights(t, k), 1);
      least = std::min(least, basis.weights(t, k));
      largest = std::max(largest, basis.weights(t, k));
    }
    EXPECT_EQ(least, 0);
    EXPECT_EQ(largest, 1);
  }
}

TEST(ModalBasis, AMotionAlongOneShapeTakesOneTarget) {
  Held held(10, 20);
  for (int64_t t = 0; t < 10; ++t)
    for (int i = 0; i < 60; ++i) held.d(t, i) = float(0.01 * double(t * t) * std::sin(i));
  const ModalBasis basis = modes(held, 1e-5);
  ASSERT_EQ(basis.targets(), 1);
  for (int64_t t = 0; t < 10; ++t) EXPECT_NEAR(basis.weights(t, 0), double(t * t) / 81, 1e-6);
}

TEST(ModalBasis, AFirstModeOfOneSignCarriesTheOthersWithoutAMean) {
  // a fall with a wave that grows with it: rank two about the rest pose
  Held held(20, 30);
  for (int64_t t = 1; t < 20; ++t)
    for (int i = 0; i < 90; ++i)
      held.d(t, i) =
          float(0.01 * double(t * t) * (1 + 0.1 * std::cos(0.9 * double(t)) * std::sin(i)));
  const ModalBasis basis = modes(held, 1e-5);
  EXPECT_EQ(basis.targets(), 2);
  EXPECT_NEAR(true_error(held, basis), basis.max_error, 1e-12);
  for (int64_t i = 0; i < basis.weights.size(); ++i) {
    EXPECT_GE(basis.weights.data()[i], 0);
    EXPECT_LE(basis.weights.data()[i], 1);
  }
}

TEST(ModalBasis, UsesTheFewestModesThatMeetTheTolerance) {
  Held held(60, 500);
  std::vector<double> amplitude;
  for (int k = 0; k < 20; ++k) amplitude.push_back(std::pow(0.5, k));
  held.fill(amplitude);
  const double tolerance = 1e-2;
  const ModalBasis basis = modes(held, tolerance);
  EXPECT_LE(basis.max_error, tolerance);
  EXPECT_NEAR(true_error(held, basis), basis.max_error, 1e-12);
  const ModalBasis fewer = modes(held, tolerance, basis.targets() - 1);
  EXPECT_LT(fewer.targets(), basis.targets());
  EXPECT_GT(true_error(held, fewer), tolerance);
}

TEST(ModalBasis, StatesTheErrorThatTooFewTargetsLeave) {
  Held held(150, 80);
  held.fill(std::vector<double>(120, 1));
  const ModalBasis basis = modes(held, 1e-9);
  EXPECT_LE(basis.targets(), 64);
  EXPECT_GT(basis.max_error, 1e-3);
  EXPECT_NEAR(true_error(held, basis), basis.max_error, 1e-12);
}

TEST(ModalBasis, MeasuresTheErrorInMetresThroughTheMap) {
  Held held(20, 30);
  held.fill({1, 0.1, 0.01});
  // sheared and mirrored, det = -6
  held.motion.parts[0].to_metres = {2, 1, 0, 0, 3, 0, 0, 0, -1};
  held.motion.parts[0].to_mesh = {0.5, -1.0 / 6, 0, 0, 1.0 / 3, 0, 0, 0, -1};
  const ModalBasis basis = modes(held, 0.2);
  EXPECT_LE(basis.max_error, 0.2);
  EXPECT_NEAR(true_error(held, basis), basis.max_error, 1e-12);
}

TEST(ModalBasis, CountsWhatAMapWithoutInverseCannotShow) {
  Held held(5, 10);
  held.fill({1});
  held.motion.parts[0].to_metres = held.motion.parts[0].to_mesh = {1, 0, 0, 0, 1, 0, 0, 0, 0};
  double flat = 0;
  for (int64_t t = 0; t < 5; ++t) {
    for (int v = 0; v < 10; ++v) flat = std::max(flat, std::abs(double(held.d(t, 3 * v + 2))));
  }
  EXPECT_NEAR(modes(held, 1e-6).max_error, flat, 1e-6);
  EXPECT_NEAR(keyframe_basis(held.motion, held.all()).max_error, flat, 1e-6);
  EXPECT_NEAR(unshown_error(held.motion, held.all()), flat, 1e-6);
}

TEST(ModalBasis, AStillFrameHasNoWeight) {
  Held held(12, 20);
  held.fill({1, 1, 1}, {0, 5});
  const ModalBasis basis = modes(held, 1e-6);
  for (const int64_t t : {0, 5}) {
    for (int k = 0; k < basis.targets(); ++k) EXPECT_EQ(basis.weights(t, k), 0.f);
  }
  EXPECT_EQ(moving_frames(held.motion, {4, 7}), (std::vector<int64_t>{4, 6, 7}));
  Held still(3, 20);
  EXPECT_EQ(modes(still, 1e-6).targets(), 0);
  EXPECT_EQ(keyframe_basis(still.motion, still.all()).targets(), 0);
}

TEST(ModalBasis, FitsFramesThatAreNoSnapshots) {
  Held held(700, 40);
  held.fill({1, 0.5, 0.2, 0.1}, {0});
  const ModalBasis basis = modes(held, 1e-5);
  EXPECT_EQ(basis.targets(), 5);
  EXPECT_EQ(basis.snapshots.size(), size_t(kMaxSnapshots));
  EXPECT_NEAR(true_error(held, basis), basis.max_error, 1e-12);
}

TEST(ModalBasis, TakesARangeOfFrames) {
  Held held(60, 40);
  held.fill({1, 0.5, 0.2}, {0});
  const FrameRange middle{20, 35};
  const ModalBasis basis = modal_basis(held.motion, middle, 1e-5, 64);
  EXPECT_EQ(basis.weights.rows(), 16);
  for (const int64_t t : basis.snapshots) EXPECT_TRUE(t >= 20 && t <= 35);
  EXPECT_LE(true_error(held, basis, middle), 1e-5);
}

TEST(ModalBasis, TakesMoreVerticesThanABlockHolds) {
  // 2^21 / 80 vertices make a block
  Held large(80, 40000);
  large.fill({1, 0.1});
  const ModalBasis basis = modes(large, 1e-4);
  EXPECT_EQ(basis.targets(), 3);
  EXPECT_NEAR(true_error(large, basis), basis.max_error, 1e-12);
}

TEST(ModalBasis, PartsShareTheirWeights) {
  Held held(30, 50);
  held.fill({1, 0.4, 0.1}, {0});
  const ModalBasis whole = modes(held, 1e-5);
  held.motion.parts = {{.first = 30, .vertices = 20}, {.first = 0, .vertices = 30}};
  const ModalBasis basis = modes(held, 1e-5);
  EXPECT_EQ(basis.targets(), whole.targets());
  const Array<float> shapes = target_shapes(held.motion, held.motion.parts[0], basis);
  for (int64_t t = 0; t < 30; ++t) {
    for (int i = 0; i < 60; ++i) {
      double d = 0;
      for (int k = 0; k < basis.targets(); ++k) d += double(basis.weights(t, k)) * shapes(k, i);
      EXPECT_NEAR(d, held.d(t, 90 + i), 2e-5);
    }
  }
}

TEST(ModalBasis, KeyframesAreTheFrames) {
  Held held(6, 25);
  held.fill({1, 1, 1, 1, 1}, {0, 3});
  const ModalBasis basis = keyframe_basis(held.motion, held.all());
  ASSERT_EQ(basis.targets(), 4);
  EXPECT_EQ(basis.snapshots, (std::vector<int64_t>{1, 2, 4, 5}));
  const Array<float> shapes = target_shapes(held.motion, held.motion.parts[0], basis);
  for (int k = 0; k < 4; ++k) {
    const int64_t frame = basis.snapshots[size_t(k)];
    EXPECT_TRUE(std::equal(shapes.row(k), shapes.row(k) + 75, held.d.row(frame)));
    for (int64_t t = 0; t < 6; ++t) EXPECT_EQ(basis.weights(t, k), t == frame ? 1.f : 0.f);
  }
  EXPECT_EQ(basis.max_error, 0);
}

}  // namespace
}  // namespace elastogen
