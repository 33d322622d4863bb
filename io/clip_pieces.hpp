// SPDX-License-Identifier: Apache-2.0
// A clip cut into pieces of time, each shown by its own morph targets. No mesh then has more
// targets than a client can hold, and the stated error is kept at any length.

#pragma once

#include "io/modal_basis.hpp"

namespace elastogen {

struct ClipPiece {
  FrameRange frames;      ///< the last one is the first of the next piece
  ModalBasis basis = {};  ///< of the displacements
  /// Frames whose normals are targets behind those of the basis. If the basis has one target a
  /// frame, these hold the normals too.
  std::vector<int64_t> normal_keys = {};
  Array<float> weights = {};  ///< (frames, targets), 0 ... 1: of the basis, then of the normal keys
  double normal_error = 0;    ///< root mean square angle of the worst frame [rad]

  bool is_keyframe() const { return basis.shares.empty(); }
};

struct PieceOptions {
  double tolerance = 0;  ///< largest error of the displacements [m], beside what no target can
                         ///< show; 0: one target a frame
  int max_targets = 64;  ///< of a piece, 4 at least
};

/// The fewest pieces of equal length that keep the tolerance and the number of targets. A piece has
/// one target a frame if that needs no more memory. Empty if nothing moves.
/// @param frames   number of frames of the clip.
/// @param normals  of some vertices in every frame, of length one, (frames, 3 vertices); without
///                 columns where no mesh has normals.
std::vector<ClipPiece> clip_pieces(const Motion& motion, int64_t frames,
                                   const Array<float>& normals, const PieceOptions& options);

}  // namespace elastogen
