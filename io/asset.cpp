// SPDX-License-Identifier: Apache-2.0
#include "io/asset.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <unordered_map>

namespace elastogen {
namespace {

constexpr int64_t kMaxAssetCount = std::numeric_limits<int32_t>::max();

Matrix4 product(const Matrix4& a, const Matrix4& b) {
  Matrix4 c = {};
  for (int j = 0; j < 4; ++j)
    for (int k = 0; k < 4; ++k)
      for (int i = 0; i < 4; ++i) c[4 * j + i] += a[4 * k + i] * b[4 * j + k];
  return c;
}

Vec3 transformed(const Matrix4& m, const Vec3& p) {
  Vec3 q;
  for (int i = 0; i < 3; ++i) q[i] = m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i];
  return q;
}

/// Whether the matrix turns a right-handed triple into a left-handed one.
bool is_mirror(const Matrix4& m) {
  return m[0] * (m[5] * m[10] - m[6] * m[9]) - m[4] * (m[1] * m[10] - m[2] * m[9]) +
             m[8] * (m[1] * m[6] - m[2] * m[5]) <
         0;
}

int parent_of(const Asset& asset, int node) {
  const int parent = asset.nodes[size_t(node)].parent;
  ELASTOGEN_CHECK_ASSET(parent >= -1 && parent < int(asset.nodes.size()), asset.path, ": node ",
                        node, " has the parent ", parent);
  return parent;
}

/// Matrices of nodes to the root, each computed once from its parent's.
class WorldMatrices {
 public:
  explicit WorldMatrices(const Asset& asset) : asset_(asset) {}

  const Matrix4& operator[](int node) {
    // climb to the root or to a node whose matrix is known, then come down
    std::vector<int> path;
    for (int n = node; n >= 0 && !world_.contains(n); n = parent_of(asset_, n)) {
      ELASTOGEN_CHECK_ASSET(path.size() < asset_.nodes.size(), asset_.path, ": node ", node, " (",
                            asset_.nodes[size_t(node)].name, ") is its own ancestor");
      path.push_back(n);
    }
    for (; !path.empty(); path.pop_back()) {
      const AssetNode& n = asset_.nodes[size_t(path.back())];
      world_[path.back()] = n.parent < 0 ? n.matrix : product(world_.at(n.parent), n.matrix);
    }
    return world_.at(node);
  }

 private:
  const Asset& asset_;
  std::unordered_map<int, Matrix4> world_;
};

/// Places of all instances in the surface. @throws Error (resources) if indices would overflow.
std::vector<SurfaceInstance> instances_of(const Asset& asset, int64_t& vertices,
                                          int64_t& triangles) {
  std::vector<SurfaceInstance> instances;
  vertices = triangles = 0;
  for (int node = 0; node < int(asset.nodes.size()); ++node) {
    const int index = asset.nodes[size_t(node)].mesh;
    if (index < 0) continue;
    ELASTOGEN_CHECK_ASSET(index < int(asset.meshes.size()), asset.path, ": node ", node,
                          " shows the mesh ", index, " of ", asset.meshes.size());
    const Mesh& mesh = asset.meshes[size_t(index)];
    int64_t own = 0;
    for (const TriangleGroup& group : mesh.groups) own += int64_t(group.corner.size() / 3);
    instances.push_back({node, index, vertices, triangles, own});
    vertices += int64_t(mesh.position.size());
    triangles += own;
    if (vertices > kMaxAssetCount || triangles > kMaxAssetCount / 3)
      throw Error(concat(asset.path, ": its instances have more than ", kMaxAssetCount,
                         " vertices or ", kMaxAssetCount / 3, " triangles"),
                  ErrorKind::kResources);
  }
  return instances;
}

/// Fills the vertices and triangles of one instance; mirrored ones are turned to face outwards.
void pose_instance(const Asset& asset, const SurfaceInstance& instance, const Matrix4& world,
                   Surface& surface) {
  const Mesh& mesh = asset.meshes[size_t(instance.mesh)];
  for (size_t i = 0; i < mesh.position.size(); ++i) {
    const Vec3 x = world == kIdentity4 ? mesh.position[i] : transformed(world, mesh.position[i]);
    std::copy(x.begin(), x.end(), surface.vertices.row(instance.first_vertex + int64_t(i)));
  }
  const int order[3] = {0, is_mirror(world) ? 2 : 1, is_mirror(world) ? 1 : 2};
  int64_t t = instance.first_triangle;
  for (const TriangleGroup& group : mesh.groups)
    for (size_t k = 0; k + 2 < group.corner.size(); k += 3, ++t) {
      for (int c = 0; c < 3; ++c) {
        const int32_t drawn = group.corner[k + size_t(order[c])];
        surface.triangles(t, c) = int32_t(instance.first_vertex) + mesh.position_of[size_t(drawn)];
      }
      surface.material(t) = group.material;
    }
}

Box box_of_triangles(const Surface& surface) {
  Box box;
  for (int64_t k = 0; k < surface.triangles.size(); ++k) {
    const double* x = surface.vertices.row(surface.triangles.data()[k]);
    box.add({x[0], x[1], x[2]});
  }
  return box;
}

double longest_edge(const Box& box) {
  return std::max({box.extent(0), box.extent(1), box.extent(2)});
}

}  // namespace

Matrix4 world_matrix(const Asset& asset, int node) {
  ELASTOGEN_CHECK(node >= 0 && node < int(asset.nodes.size()), asset.path, ": there is no node ",
                  node);
  return WorldMatrices(asset)[node];
}

std::vector<Matrix4> world_matrices(const Asset& asset) {
  WorldMatrices world(asset);
  std::vector<Matrix4> matrices;
  for (size_t n = 0; n < asset.nodes.size(); ++n) matrices.push_back(world[int(n)]);
  return matrices;
}

int64_t repeated_positions(const Asset& asset) {
  int64_t count = 0, last = -1;
  for (const Mesh& mesh : asset.meshes) {
    count += int64_t(mesh.file_position.size());
    for (const int32_t p : mesh.file_position) last = std::max(last, int64_t(p));
  }
  return count - (last + 1);
}

Surface pose_surface(const Asset& asset, double size) {
  ELASTOGEN_CHECK(size >= 0 && std::isfinite(size), "the size must be positive, got ", size);
  Surface surface;
  int64_t vertices = 0, triangles = 0;
  surface.instances = instances_of(asset, vertices, triangles);
  ELASTOGEN_CHECK_ASSET(triangles > 0, asset.path, ": has no triangle: nothing to simulate");
  surface.vertices = Array<double>(vertices, 3);
  surface.triangles = Array<int32_t>(triangles, 3);
  surface.material = Array<int32_t>(triangles);
  WorldMatrices world(asset);
  for (const SurfaceInstance& instance : surface.instances)
    pose_instance(asset, instance, world[instance.node], surface);

  // scale by the longest edge of the box of the used vertices
  const double longest = longest_edge(box_of_triangles(surface));
  ELASTOGEN_CHECK_ASSET(longest > 0, asset.path, ": all its triangles lie in one point");
  ELASTOGEN_CHECK_ASSET(longest > 1 / kMaxLength && longest < kMaxLength, asset.path,
                        ": its longest edge of ", longest, " is out of range");
  surface.scale = size > 0 ? size / longest : asset.unit > 0 ? asset.unit : 1;
  const double edge = longest * surface.scale;
  ELASTOGEN_CHECK_ASSET(edge > 1 / kMaxLength && edge < kMaxLength, asset.path,
                        ": its longest edge of ", edge, " m is out of range");
  for (int64_t k = 0; k < surface.vertices.size(); ++k) {
    double& x = surface.vertices.data()[k];
    x *= surface.scale;
    ELASTOGEN_CHECK_ASSET(std::isfinite(x), asset.path, ": vertex ", k / 3,
                          " is not finite once it is placed and scaled");
  }
  static_cast<Box&>(surface.box) = box_of_triangles(surface);
  settle(surface);
  return surface;
}

void settle(Surface& surface) {
  constexpr double kFar = 100;  // [longest edges]
  Box& box = surface.box;
  double farthest = 0;
  for (int d = 0; d < 3; ++d)
    farthest = std::max({farthest, std::abs(box.lower[d]), std::abs(box.upper[d])});
  if (!(farthest > kFar * longest_edge(box))) return;
  // a multiple of a power of two no longer than the body, so that subtracting it does not round
  const double unit = std::exp2(std::floor(std::log2(longest_edge(box))));
  Vec3 origin;
  for (size_t d = 0; d < 3; ++d)
    origin[d] = unit * std::round((box.lower[d] + box.upper[d]) / 2 / unit);
  for (int64_t v = 0; v < surface.vertices.rows(); ++v)
    for (int d = 0; d < 3; ++d) surface.vertices(v, d) -= origin[size_t(d)];
  box.lower = minus(box.lower, origin);
  box.upper = minus(box.upper, origin);
  surface.box.origin = origin;
}

}  // namespace elastogen
