// SPDX-License-Identifier: Apache-2.0
#include "io/clip_pieces.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace elastogen {
namespace {

/// A motion in memory in which every frame has noise of its own besides a common wave.
struct Noisy {
  Array<float> d;
  Motion motion;

  Noisy(int64_t frames, int64_t vertices, double noise) : d(frames, int(3 * vertices)) {
    std::mt19937 random(3);
    std::normal_distribution<double> normal;
    for (int64_t t = 1; t < frames; ++t)
      for (int i = 0; i < d.cols(); ++i)
        d(t, i) = float(std::sin(0.1 * double(t) + i) + noise * normal(random));
    motion.parts = {{.vertices = vertices}};
    motion.read = [this](int64_t t, int64_t first, int64_t count, float* to) {
      std::copy_n(d.row(t) + 3 * first, 3 * count, to);
    };
  }
  Noisy(const Noisy&) = delete;
};

double worst(const std::vector<ClipPiece>& pieces) {
  double error = 0;
  for (const ClipPiece& piece : pieces) error = std::max(error, piece.basis.max_error);
  return error;
}

TEST(ClipPieces, OnePieceWhereTheTargetsSuffice) {
  const Noisy clip(200, 40, 0);
  const auto pieces = clip_pieces(clip.motion, 200, Array<float>(200, 0), {1e-4, 64});
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_EQ(pieces[0].frames.last, 199);
  EXPECT_LE(pieces[0].basis.targets(), 3);
  EXPECT_LE(worst(pieces), 1e-4);
}

TEST(ClipPieces, PiecesMeetAndKeepTheToleranceAndTheNumberOfTargets) {
  const Noisy clip(150, 60, 0.1);
  const auto pieces = clip_pieces(clip.motion, 150, Array<float>(150, 0), {1e-3, 32});
  ASSERT_GT(pieces.size(), 1u);
  EXPECT_EQ(pieces.front().frames.first, 0);
  EXPECT_EQ(pieces.back().frames.last, 149);
  for (size_t p = 0; p < pieces.size(); ++p) {
    EXPECT_LE(pieces[p].weights.cols(), 32);
    EXPECT_EQ(pieces[p].weights.rows(), pieces[p].frames.count());
    if (p > 0) {
      EXPECT_EQ(pieces[p].frames.first, pieces[p - 1].frames.last);
    }
  }
  EXPECT_LE(worst(pieces), 1e-3);
}

TEST(ClipPieces, KeyframesAreHeldToTheSameNumber) {
  const Noisy clip(100, 20, 0.1);
  const auto pieces = clip_pieces(clip.motion, 100, Array<float>(100, 0), {0, 40});
  EXPECT_EQ(pieces.size(), 3u);
  for (const ClipPiece& piece : pieces) {
    EXPECT_TRUE(piece.is_keyframe());
    EXPECT_LE(piece.weights.cols(), 40);
  }
  EXPECT_EQ(worst(pieces), 0);
}

TEST(ClipPieces, FramesAreTakenWhereModesWouldBeMore) {
  const Noisy clip(12, 60, 1);  // eleven frames that have nothing in common
  const auto pieces = clip_pieces(clip.motion, 12, Array<float>(12, 0), {1e-6, 64});
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_TRUE(pieces[0].is_keyframe());
  EXPECT_EQ(pieces[0].weights.cols(), 11);
}

TEST(ClipPieces, NormalsHaveTargetsBehindThoseOfTheDisplacements) {
  const Noisy clip(80, 40, 0);
  Array<float> normals(80, 3);
  for (int64_t t = 0; t < 80; ++t) {
    normals(t, 0) = float(std::cos(0.05 * double(t)));
    normals(t, 1) = float(std::sin(0.05 * double(t)));
  }
  const auto pieces = clip_pieces(clip.motion, 80, normals, {1e-4, 64});
  ASSERT_EQ(pieces.size(), 1u);
  const ClipPiece& piece = pieces[0];
  EXPECT_GE(piece.normal_keys.size(), 2u);
  EXPECT_EQ(piece.weights.cols(), piece.basis.targets() + int(piece.normal_keys.size()));
  EXPECT_GT(piece.normal_error, 0);
  for (int64_t i = 0; i < piece.weights.size(); ++i) {
    EXPECT_GE(piece.weights.data()[i], 0);
    EXPECT_LE(piece.weights.data()[i], 1);
  }
}

TEST(ClipPieces, NothingMovesNothingIsWritten) {
  const Noisy clip(1, 10, 1);
  EXPECT_TRUE(clip_pieces(clip.motion, 1, Array<float>(1, 0), {1e-3, 64}).empty());
  EXPECT_ANY_THROW(clip_pieces(clip.motion, 1, Array<float>(1, 0), {1e-3, 3}));
}

TEST(ClipPieces, WhatNoTargetCanShowDoesNotSplitTheClip) {
  Noisy clip(100, 20, 0);
  clip.motion.parts[0].to_metres = clip.motion.parts[0].to_mesh = {1, 0, 0, 0, 1, 0, 0, 0, 0};
  const auto pieces = clip_pieces(clip.motion, 100, Array<float>(100, 0), {1e-4, 8});
  ASSERT_EQ(pieces.size(), 1u);
  EXPECT_GT(pieces[0].basis.max_error, 0.1);
}

}  // namespace
}  // namespace elastogen
