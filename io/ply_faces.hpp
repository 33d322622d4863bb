// SPDX-License-Identifier: Apache-2.0
// Faces of a PLY file, and colours of its faces and vertices.

#pragma once

#include "io/face_list.hpp"
#include "io/ply_values.hpp"

namespace elastogen {

/// Finds the columns red, green, blue and perhaps alpha of an element.
class PlyColour {
 public:
  explicit PlyColour(const PlyElement& element);

  bool is_there() const { return column_[0] >= 0 && column_[1] >= 0 && column_[2] >= 0; }
  bool has(int column) const;

  /// Linear RGBA; integers are sRGB, floats linear.
  std::array<float, 4> of(const std::vector<double>& row) const;

 private:
  std::array<int, 4> column_;    ///< -1 for none
  std::array<double, 4> range_;  ///< range of each column's type, 0 for floats
};

/// Reads the element `face`: vertex_indices, texcoord (u v of each corner), texnumber (the
/// material) and colours. Names of further properties are added to `left_out`. Without texnumber
/// all faces have the first material.
/// @param textures  number of textures that the file names.
/// @throws Error (asset) naming the face: no list of indices, another number of coordinates than
///         two a corner, too many corners.
FaceList read_ply_faces(const PlyElement& face, size_t textures, PlyValues& values,
                        const std::string& path, std::vector<std::string>& left_out);

}  // namespace elastogen
