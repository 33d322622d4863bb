// SPDX-License-Identifier: Apache-2.0
// An asset as its file has it: meshes, points or splats in the file's own numbers and order, node
// tree and materials. And the surface in metres that the solver gets.

#pragma once

#include "core/array.hpp"
#include "core/base.hpp"
#include "io/finding.hpp"
#include "io/own_columns.hpp"
#include "io/ply_header.hpp"

#include <optional>
#include <string>
#include <vector>

namespace elastogen {

/// Column-major 4x4, as glTF has it.
using Matrix4 = std::array<double, 16>;
inline constexpr Matrix4 kIdentity4 = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

/// Longest edge of an asset; the shortest is 1 / it. Volumes then neither overflow nor vanish.
inline constexpr double kMaxLength = 1e100;

/// Triangles of one material.
struct TriangleGroup {
  int material = -1;            ///< index into Asset::materials, -1 for none
  std::vector<int32_t> corner;  ///< three drawn vertices a triangle
  int primitive = -1;           ///< glTF: index of the primitive in its mesh
  bool has_uv = true;           ///< the mesh's uv is valid for its corners
};

/// A property of vertices without a meaning here; outputs that can hold it keep it.
struct OwnColumn {
  std::string name;
  PlyType type = PlyType::kFloat64;  ///< of its numbers in the file
  std::vector<double> value;         ///< per position
};

/// A mesh in its own space. A drawn vertex is a position with attributes; the first ones are the
/// file's positions in the file's order, further ones split a position at a seam (OBJ).
struct Mesh {
  std::string name;
  std::vector<Vec3> position;        ///< in the file's numbers and order
  std::vector<int32_t> position_of;  ///< position of each drawn vertex; the first are 0, 1, 2, ...
  std::vector<std::array<float, 2>> uv;      ///< per drawn vertex, or empty; v as glTF (down)
  std::vector<std::array<float, 3>> normal;  ///< per drawn vertex, or empty
  std::vector<std::array<float, 4>> colour;  ///< per drawn vertex, linear RGBA, or empty
  std::vector<TriangleGroup> groups;
  /// Number of each position in the file; empty if that is its place among the positions of all
  /// meshes. Meshes of one file may share positions.
  std::vector<int32_t> file_position;
  std::vector<OwnColumn> own;         ///< only of an asset that is one mesh, shown once
  std::vector<OwnColumn> attributes;  ///< of glTF if asked for, "_NAME" or "_NAME.x"; NaN: none
};

/// A node of the scene tree; several nodes may show one mesh.
struct AssetNode {
  std::string name;
  int parent = -1;
  Matrix4 matrix = kIdentity4;  ///< to the parent
  int mesh = -1;                ///< index into Asset::meshes, -1 for none
};

struct AssetMaterial {
  std::string name;
  std::array<float, 4> base_colour = {0.8f, 0.8f, 0.8f, 1};
  std::string texture;  ///< path of the base colour image, found beside the asset; empty for none
  bool double_sided = false;
};

/// A point cloud: a scan of a surface, at most with normals and colours.
struct PointCloud {
  std::vector<Vec3> position;                ///< in the file's numbers and order
  std::vector<std::array<float, 3>> normal;  ///< per point, or empty
  std::vector<std::array<float, 4>> colour;  ///< per point, linear RGBA, or empty
  OwnColumns own;                            ///< further columns of the file
};

/// 3-D Gaussian splats (Kerbl et al. 2023): covariance R(rotation) diag(scale^2) R^T, colour by
/// spherical harmonics in the direction of view.
struct SplatCloud {
  std::vector<Vec3> position;                  ///< in the file's numbers and order
  std::vector<std::array<float, 3>> scale;     ///< standard deviations, > 0, in the file's numbers
  std::vector<std::array<float, 4>> rotation;  ///< unit quaternion w x y z
  std::vector<float> opacity;                  ///< 0 ... 1
  int degree = 0;                              ///< of the harmonics, 0 ... 3
  std::vector<float> harmonics;  ///< (splats, (degree + 1)^2, 3): coefficient, then colour channel
  OwnColumns own;                ///< further columns of the file
};

struct Asset {
  std::string path;
  std::string format;  ///< "obj", "ply", "stl", "gltf", "glb", ...
  std::vector<Mesh> meshes;
  std::vector<AssetNode> nodes;  ///< in file order; every mesh is shown by one node at least
  std::vector<AssetMaterial> materials;
  std::optional<PointCloud> points;  ///< in place of meshes
  std::optional<SplatCloud> splats;  ///< in place of meshes
  std::vector<Finding> findings;
  int up = 0;       ///< axis that points up where the format says so: +-1 x, +-2 y, +-3 z; else 0
  double unit = 0;  ///< metres per file unit where the format says so (glTF: 1), else 0
};

/// Place of the vertices of one shown mesh in a Surface.
struct SurfaceInstance {
  int node = -1;
  int mesh = -1;
  int64_t first_vertex = 0;  ///< one surface vertex per position of the mesh, in its order
  int64_t first_triangle = 0;
  int64_t triangles = 0;
};

/// A box, and the origin of its numbers in the asset's coordinates [m].
struct PlacedBox : Box {
  Vec3 origin = {};
};

/// Every shown mesh, posed by the node tree, in metres and the asset's own axes. Coordinates count
/// from box.origin. It is zero, except for a body that lies a hundred of its edges or more from the
/// asset's origin: such a body is computed about its own middle.
struct Surface {
  Array<double> vertices;    ///< [m], (vertices, 3)
  Array<int32_t> triangles;  ///< (triangles, 3)
  Array<int32_t> material;   ///< asset material of each triangle, -1 for none, (triangles, 1)
  Array<int32_t> part;  ///< piece of each triangle if pieces are kept apart (voxelize), else empty
  std::vector<SurfaceInstance> instances;
  double scale = 1;  ///< metres per file unit that was applied (--size)
  PlacedBox box;     ///< of the vertices that triangles use [m]
};

/// Matrix of a node to the asset's root. @throws Error (asset) on a cycle.
Matrix4 world_matrix(const Asset& asset, int node);

/// Matrices of all nodes to the asset's root. @throws Error (asset) on a cycle.
std::vector<Matrix4> world_matrices(const Asset& asset);

/// Moves the origin of a surface that lies far out to its middle: vertices, box, box.origin.
void settle(Surface& surface);

/// Number of positions that meshes share with other meshes in the file.
int64_t repeated_positions(const Asset& asset);

/// Poses an asset and scales it to a longest edge of `size` metres (0: as the file has it).
/// @throws Error (asset) if there is no triangle, no extent, or a number that is not finite.
Surface pose_surface(const Asset& asset, double size = 0);

}  // namespace elastogen
