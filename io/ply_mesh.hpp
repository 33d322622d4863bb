// SPDX-License-Identifier: Apache-2.0
// All shown meshes as one PLY mesh in the order of the file, and its frames.

#pragma once

#include "io/frame_files.hpp"

namespace elastogen {

/// The attributes that PLY can hold for meshes whose positions it keeps: one normal, uv and colour
/// for each vertex, or uv for each corner and a colour for each face.
class PlyMesh {
 public:
  /// @param path  path of the output; textures are named relative to its folder.
  PlyMesh(const std::string& path, const Asset& asset, const Surface& surface,
          const FileOrder& order);

  /// Lines of the header from the comments on, without end_header.
  std::string header() const;

  /// Vertices and faces of a frame.
  std::string body(const Span<const double>& displacement);

  /// Number of vertices whose corners have several normals, or that have none while others have
  /// one. If there are any, no normals are written.
  int64_t without_normal() const { return without_normal_; }

 private:
  void add_instance(const SurfaceInstance& instance);
  void find_vertices();
  void choose();
  void choose_textures(const std::string& path);
  void fill_faces();
  void append_vertex(size_t v, const Vec3& x, std::string& bytes) const;
  std::array<float, 4> face_colour(const int32_t* corner) const;

  const Asset& asset_;
  const Surface& surface_;
  const FileOrder& order_;
  bool is_double_;
  Mesh flat_;                                 ///< drawn vertices and triangles of all instances
  std::vector<uint8_t> has_normal_, has_uv_;  ///< of each drawn vertex
  std::vector<uint8_t> textured_;             ///< of each triangle: 1 if its uv is valid
  std::vector<int32_t> vertex_;  ///< the drawn vertex of each vertex of the file, -1 for none
  bool normals_ = false, vertex_uv_ = false, corner_uv_ = false;
  bool vertex_colour_ = false, face_colour_ = false, numbers_ = false;
  int64_t without_normal_ = 0;
  std::vector<std::string> textures_;  ///< names
  std::vector<int32_t> texture_of_;    ///< of each material, -1 for none
  std::string faces_;                  ///< their bytes, the same in every frame
  Array<double> moved_;                ///< displacement in the numbers of the asset
  Array<float> turned_;                ///< change of the normals
};

}  // namespace elastogen
