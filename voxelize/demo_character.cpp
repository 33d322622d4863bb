// SPDX-License-Identifier: Apache-2.0
#include "voxelize/demo_character.hpp"

#include "core/vec3.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/LevelSetFilter.h>
#include <openvdb/tools/LevelSetSphere.h>
#include <openvdb/tools/VolumeToMesh.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>

namespace elastogen {
namespace {

constexpr double kVoxel = 0.02;  // voxel edge of the level sets [m]
constexpr double kNeck = 0.5;    // height where the head begins [m]
constexpr double kHeight = 1;    // [m]

/// A limb: balls with centre and radius interpolated linearly between its ends. [m]
struct Limb {
  Vec3 from;
  double from_radius;
  Vec3 to;
  double to_radius;
};

/// The half of the figure with x >= 0; the other half is its mirror image.
constexpr Limb kLimbs[] = {
    {{0.00, 0.26, 0.00}, 0.195, {0.00, 0.39, 0.00}, 0.150},    // belly to chest
    {{0.00, 0.39, 0.00}, 0.120, {0.00, 0.56, 0.00}, 0.110},    // neck
    {{0.00, 0.66, 0.01}, 0.215, {0.00, 0.69, 0.01}, 0.200},    // head
    {{0.00, 0.63, 0.20}, 0.045, {0.00, 0.63, 0.23}, 0.040},    // nose
    {{0.17, 0.76, 0.00}, 0.085, {0.24, 0.82, 0.00}, 0.075},    // ears
    {{0.07, 0.84, 0.00}, 0.036, {0.11, 0.94, 0.01}, 0.034},    // antennae
    {{0.11, 0.94, 0.01}, 0.045, {0.112, 0.945, 0.01}, 0.045},  // their tips
    {{0.13, 0.40, 0.02}, 0.062, {0.29, 0.31, 0.06}, 0.055},    // arms
    {{0.29, 0.31, 0.06}, 0.065, {0.30, 0.30, 0.07}, 0.065},    // hands
    {{0.10, 0.20, 0.00}, 0.085, {0.11, 0.08, 0.01}, 0.075},    // legs
    {{0.11, 0.06, 0.03}, 0.072, {0.12, 0.06, 0.10}, 0.068},    // feet
    {{0.00, 0.22, -0.17}, 0.05, {0.00, 0.25, -0.24}, 0.06},    // tail
};

/// Painted places: everything within the radius. [m]
struct Paint {
  Vec3 centre;
  double radius;
  std::array<float, 4> colour;
};

constexpr std::array<float, 4> kSkin = {0.10f, 0.48f, 0.45f, 1}, kFace = {0.95f, 0.62f, 0.25f, 1};
constexpr Paint kPaints[] = {
    {{0.00, 0.26, 0.19}, 0.12, {0.85f, 0.80f, 0.55f, 1}},   // belly
    {{0.09, 0.72, 0.20}, 0.040, {0.02f, 0.02f, 0.03f, 1}},  // eyes
    {{0.09, 0.72, 0.20}, 0.058, {0.95f, 0.95f, 0.92f, 1}},
    {{0.00, 0.63, 0.24}, 0.045, {0.75f, 0.12f, 0.10f, 1}},  // nose
    {{0.24, 0.82, 0.02}, 0.070, {0.85f, 0.35f, 0.25f, 1}},  // ears
    {{0.11, 0.94, 0.01}, 0.055, {0.90f, 0.15f, 0.12f, 1}},  // tips
    {{0.30, 0.30, 0.07}, 0.075, {0.95f, 0.62f, 0.25f, 1}},  // hands
    {{0.12, 0.05, 0.08}, 0.095, {0.35f, 0.12f, 0.30f, 1}},  // feet
};

/// The limbs, blended into one level set.
openvdb::FloatGrid::Ptr make_level_set() {
  openvdb::initialize();
  openvdb::FloatGrid::Ptr body;
  // the union of balls along each limb and its mirror image
  const auto add = [&](const Vec3& centre, double radius) {
    const auto ball = openvdb::tools::createLevelSetSphere<openvdb::FloatGrid>(
        static_cast<float>(radius), openvdb::Vec3f(centre[0], centre[1], centre[2]),
        static_cast<float>(kVoxel));
    if (body)
      openvdb::tools::csgUnion(*body, *ball);
    else
      body = ball;
  };
  for (const Limb& limb : kLimbs) {
    const double smaller = std::min(limb.from_radius, limb.to_radius);
    const int balls = 2 + static_cast<int>(norm(minus(limb.to, limb.from)) / (0.3 * smaller));
    for (const double mirror : {1.0, -1.0})
      for (int i = 0; i < balls; ++i) {
        const double s = i / (balls - 1.0);
        Vec3 centre = plus(scaled(limb.from, 1 - s), scaled(limb.to, s));
        centre[0] *= mirror;
        add(centre, (1 - s) * limb.from_radius + s * limb.to_radius);
      }
  }
  // smoothing blends them
  openvdb::tools::LevelSetFilter<openvdb::FloatGrid> filter(*body);
  for (int i = 0; i < 4; ++i) filter.meanCurvature();
  return body;
}

/// Moves and scales the points so that they stand on y = 0, kHeight tall.
void stand(std::vector<Vec3>& points) {
  Box box;
  for (const Vec3& p : points) box.add(p);
  const double scale = kHeight / box.extent(1);
  for (Vec3& p : points) p = scaled({p[0], p[1] - box.lower[1], p[2]}, scale);
}

/// The zero set of a level set as triangles that face outwards.
std::vector<std::array<int32_t, 3>> to_triangles(const openvdb::FloatGrid& grid,
                                                 std::vector<Vec3>& points) {
  std::vector<openvdb::Vec3s> vertices;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, vertices, triangles, quads, 0.0, 0.0);
  for (const openvdb::Vec3s& p : vertices) points.push_back({p[0], p[1], p[2]});
  std::vector<std::array<int32_t, 3>> result;
  const auto add = [&](uint32_t a, uint32_t b, uint32_t c) {
    // OpenVDB winds faces clockwise as seen from outside
    result.push_back({static_cast<int32_t>(a), static_cast<int32_t>(c), static_cast<int32_t>(b)});
  };
  for (const openvdb::Vec3I& t : triangles) add(t[0], t[1], t[2]);
  for (const openvdb::Vec4I& q : quads) {
    add(q[0], q[1], q[2]);
    add(q[0], q[2], q[3]);
  }
  return result;
}

std::array<float, 4> colour_at(const Vec3& p) {
  for (const Paint& paint : kPaints)
    if (norm(minus({std::abs(p[0]), p[1], p[2]}, paint.centre)) < paint.radius) return paint.colour;
  return p[1] > kNeck ? kFace : kSkin;
}

void set_attributes(Mesh& mesh, std::span<const std::array<int32_t, 3>> triangles) {
  std::vector<Vec3> normal(mesh.position.size());
  for (const auto& [a, b, c] : triangles) {
    const Vec3& p = mesh.position[a];
    const Vec3 area = cross(minus(mesh.position[b], p), minus(mesh.position[c], p));
    for (const int32_t v : {a, b, c}) normal[v] = plus(normal[v], area);
  }
  for (size_t v = 0; v < mesh.position.size(); ++v) {
    const Vec3& p = mesh.position[v];
    const Vec3 n = scaled(normal[v], 1 / norm(normal[v]));
    const double turn = std::atan2(p[0], p[2]) / (2 * std::numbers::pi) + 0.5;
    mesh.position_of.push_back(static_cast<int32_t>(v));
    mesh.uv.push_back({static_cast<float>(turn), static_cast<float>(1 - p[1] / kHeight)});
    mesh.normal.push_back({float(n[0]), float(n[1]), float(n[2])});
    mesh.colour.push_back(colour_at(p));
  }
}

/// A drawn vertex at the same place with u + 1, for triangles across the seam of uv.
int32_t beyond_seam(Mesh& mesh, std::vector<int32_t>& twin, int32_t v) {
  if (twin[v] >= 0) return twin[v];
  mesh.position_of.push_back(v);
  mesh.uv.push_back({mesh.uv[v][0] + 1, mesh.uv[v][1]});
  mesh.normal.push_back(mesh.normal[v]);
  mesh.colour.push_back(mesh.colour[v]);
  return twin[v] = static_cast<int32_t>(mesh.position_of.size()) - 1;
}

void set_groups(Mesh& mesh, std::span<const std::array<int32_t, 3>> triangles) {
  mesh.groups = {{0, {}, -1}, {1, {}, -1}};
  std::vector<int32_t> twin(mesh.position.size(), -1);
  for (const auto& triangle : triangles) {
    double height = 0;
    float lowest = 1, highest = 0;
    for (const int32_t v : triangle) {
      height += mesh.position[v][1] / 3;
      lowest = std::min(lowest, mesh.uv[v][0]);
      highest = std::max(highest, mesh.uv[v][0]);
    }
    for (const int32_t v : triangle)
      mesh.groups[height > kNeck].corner.push_back(
          highest - lowest > 0.5f && mesh.uv[v][0] < 0.5f ? beyond_seam(mesh, twin, v) : v);
  }
}

}  // namespace

Asset demo_character() {
  Asset asset;
  // materials of body and head
  asset.path = "demo";
  asset.format = "demo";
  asset.up = 2;
  asset.unit = 1;
  asset.up = 2;
  asset.unit = 1;
  AssetMaterial body, head;
  body.name = "body";
  head.name = "head";
  body.base_colour = head.base_colour = {1, 1, 1, 1};  // the vertices have the colours
  asset.materials = {body, head};

  // the mesh, and one node that shows it
  Mesh mesh;
  mesh.name = "character";
  const auto triangles = to_triangles(*make_level_set(), mesh.position);
  stand(mesh.position);
  set_attributes(mesh, triangles);
  set_groups(mesh, triangles);
  asset.meshes.push_back(std::move(mesh));
  AssetNode node;
  node.name = "character";
  node.mesh = 0;
  asset.nodes.push_back(node);
  return asset;
}

Array<int32_t> demo_regions(const VoxelGrid& grid) {
  Array<int32_t> region(grid.voxel_count());
  for (int64_t v = 0; v < grid.voxel_count(); ++v)
    region(v) = grid.origin[1] + grid.h * (grid.voxel_coord(v, 1) + 0.5) > kNeck;
  return region;
}

}  // namespace elastogen
