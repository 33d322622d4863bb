// SPDX-License-Identifier: Apache-2.0
// Polygons of a file whose attributes may belong to vertices, corners or faces.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// Faces in the file's order; each list except the first two may be empty.
struct FaceList {
  std::vector<int32_t> corner;               ///< positions, face after face
  std::vector<int32_t> length;               ///< corners of each face
  std::vector<std::array<float, 2>> uv;      ///< of each corner, v as glTF (down)
  std::vector<uint8_t> has_uv;               ///< of each face if there is uv: 1 if its own is valid
  std::vector<int32_t> material;             ///< of each face, -1 for none
  std::vector<std::array<float, 4>> colour;  ///< of each face, linear RGBA
};

/// Gives a mesh with positions and attributes of vertices its drawn vertices and triangles. A
/// position is split where corners differ in uv or colour; colours of vertices replace those of
/// faces (a finding); triangles are grouped by material and by whether they have uv. Faces of fewer
/// than three corners are left out with a finding.
/// @throws Error (asset) naming the face: an index beyond the positions.
void add_faces(const FaceList& faces, Mesh& mesh, Asset& asset);

}  // namespace elastogen
