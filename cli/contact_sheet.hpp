// SPDX-License-Identifier: Apache-2.0
// Frames of a surface on one PNG, drawn by a small z-buffer; no graphics library.

#pragma once

#include "core/array.hpp"

#include <optional>
#include <span>
#include <string>

namespace elastogen {

struct ContactSheetOptions {
  int columns = 4;
  int tile = 320;  ///< edge of a tile [pixels]
  int up = 1;      ///< axis that points up, 0 ... 2
  std::optional<double> floor =
      {};  ///< height of a ground along up, drawn with the body's shadow [m]
};

/// Draws each frame on a tile, row by row, all by one camera: orthographic, from the front, right
/// and above, as near as all frames allow. Both sides of a triangle are lit (Lambert, smooth
/// normals), so that the winding does not matter.
/// @param path       the file, written under a temporary name first.
/// @param frames     positions [m], (vertices, 3) each, finite.
/// @param triangles  (triangles, 3)
/// @param colours    sRGB in 0 ... 1, (vertices, 3)
/// @throws Error     on wrong shapes, no frame or indices out of range; (resources) if the disk
///                   refuses the file.
void write_contact_sheet(const std::string& path, std::span<const Array<double>> frames,
                         In<int32_t> triangles, In<float> colours,
                         const ContactSheetOptions& options = {});

}  // namespace elastogen
