// SPDX-License-Identifier: Apache-2.0
// Objects and groups of an OBJ file as nodes, and the mesh of each.

#pragma once

#include "io/asset.hpp"

#include <unordered_map>

namespace elastogen {

/// Position, uv and normal of a face's corner, -1 for none.
using ObjCorner = std::array<int32_t, 3>;

struct ObjFace {
  int64_t first = 0;  ///< of its corners
  int32_t corners = 0;
  int32_t line = 0;
  int32_t material = -1;
  int32_t node = 0;
};

/// What the statements of a file say.
struct ObjShape {
  std::vector<Vec3> position;
  std::vector<std::array<float, 2>> uv;      ///< v as glTF (down)
  std::vector<std::array<float, 3>> normal;  ///< in the file's numbers
  std::vector<std::array<float, 4>> colour;  ///< of the positions up to the last with a colour
  std::vector<ObjCorner> corners;
  std::vector<ObjFace> faces;
};

/// Nodes in the order of their first face: one for each object (`o`), and below it one for each of
/// its groups (`g`). Groups outside objects stand at the root, and so does the node of faces that
/// belong to neither, which is named after the file. Equal names mean one node.
class ObjNodes {
 public:
  /// @param asset  gets the nodes; outlives this.
  explicit ObjNodes(Asset& asset) : asset_(asset) {}

  void begin_object(std::string_view name);
  void begin_group(std::string_view name);

  /// Node of the faces that follow.
  int32_t node();

 private:
  int32_t child(int32_t parent, const std::string& name);

  Asset& asset_;
  std::string object_, group_;
  int32_t node_ = -1;
  std::unordered_map<std::string, int32_t> node_of_;  ///< by the parent and the name
};

/// Gives each node that has faces a mesh with the positions that it uses, in the file's order; the
/// first one also those that no face uses. Triangles are grouped by material and by whether all
/// corners of their face have coordinates of a texture.
void build_obj_meshes(ObjShape shape, Asset& asset);

}  // namespace elastogen
