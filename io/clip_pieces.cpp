// SPDX-License-Identifier: Apache-2.0
#include "io/clip_pieces.hpp"

#include "core/error.hpp"
#include "io/normal_keys.hpp"

#include <algorithm>
#include <optional>

namespace elastogen {

namespace {

/// Two arrays beside each other.
Array<float> beside(const Array<float>& a, const Array<float>& b) {
  Array<float> result(a.rows(), a.cols() + b.cols());
  for (int64_t r = 0; r < a.rows(); ++r) {
    std::copy_n(a.row(r), a.cols(), result.row(r));
    std::copy_n(b.row(r), b.cols(), result.row(r) + a.cols());
  }
  return result;
}

ClipPiece keyframes(const Motion& motion, const FrameRange& frames) {
  ClipPiece piece{.frames = frames, .basis = keyframe_basis(motion, frames)};
  piece.weights = piece.basis.weights;
  return piece;
}

/// One piece of a clip; no value if neither modes nor frames keep within the limits.
std::optional<ClipPiece> fitted(const Motion& motion, const FrameRange& frames,
                                const Array<float>& normals, const PieceOptions& options) {
  constexpr int kFewestKeys = 2;
  const std::vector<int64_t> moving = moving_frames(motion, frames);
  const auto count = int64_t(moving.size());
  const bool has_normals = normals.cols() > 0;
  if (count == 0) return ClipPiece{.frames = frames};
  if (options.tolerance > 0 && count > 1) {
    const int most = options.max_targets - (has_normals ? kFewestKeys : 0);
    ClipPiece piece{.frames = frames};
    piece.basis = modal_basis(motion, frames, options.tolerance, most);
    bool good = piece.basis.max_error <= options.tolerance;
    NormalKeys keys;
    if (good && has_normals) {
      keys = normal_keys(normals, frames, moving, options.max_targets - piece.basis.targets());
      good = keys.error <= kNormalTolerance;
    }
    // rows of vectors to store; with one target a frame each needs positions and normals
    const int64_t rows = piece.basis.targets() + int64_t(keys.frames.size());
    if (good && rows < (has_normals ? 2 : 1) * count) {
      piece.weights = has_normals ? beside(piece.basis.weights, keys.weights) : piece.basis.weights;
      piece.normal_keys = std::move(keys.frames);
      piece.normal_error = keys.error;
      return piece;
    }
  }
  if (count > options.max_targets) return {};
  return keyframes(motion, frames);
}

}  // namespace

std::vector<ClipPiece> clip_pieces(const Motion& motion, int64_t frames,
                                   const Array<float>& normals, const PieceOptions& options) {
  ELASTOGEN_CHECK(options.max_targets >= 4, "max_targets must be 4 at least, got ",
                  options.max_targets);
  if (moving_frames(motion, {0, frames - 1}).empty()) return {};
  PieceOptions limits = options;
  if (limits.tolerance > 0) limits.tolerance += unshown_error(motion, {0, frames - 1});
  for (int64_t count = 1;; ++count) {
    std::vector<ClipPiece> pieces;
    for (int64_t p = 0; p < count; ++p) {
      const FrameRange range{p * (frames - 1) / count, (p + 1) * (frames - 1) / count};
      std::optional<ClipPiece> piece = fitted(motion, range, normals, limits);
      if (!piece) break;
      pieces.push_back(std::move(*piece));
    }
    if (int64_t(pieces.size()) == count) return pieces;
  }
}

}  // namespace elastogen
