// SPDX-License-Identifier: Apache-2.0
#include "voxelize/from_points.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "voxelize/point_spacing.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/LevelSetRebuild.h>
#include <openvdb/tools/LevelSetUtil.h>
#include <openvdb/tools/Morphology.h>
#include <openvdb/tools/ParticlesToLevelSet.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

using openvdb::FloatGrid;

// lengths of the level sets are in voxels
constexpr float kRadius = 3;       // radius of the balls
constexpr float kCore = 1.2f;      // least depth of an inside below the eroded surface
constexpr float kInnerBand = 6;    // more than the deepest erosion and the core
constexpr double kSpacings = 1.5;  // ball radius / spacing
constexpr double kFloaterShare = 0.005, kMostFloaters = 0.2, kMostLost = 0.1;
constexpr double kMaxPoints = 1.2e6;  // 40 million voxels at 31 for each point
constexpr double kMaxExtent = 1e6;
constexpr double kCrumb = 0.5 * kRadius * kRadius * kRadius;

/// The points in voxels, in the form in which OpenVDB accepts particles.
struct Balls {
  using PosType = openvdb::Vec3R;
  std::vector<openvdb::Vec3R> centre;
  size_t size() const { return centre.size(); }
  void getPos(size_t n, openvdb::Vec3R& p) const { p = centre[n]; }
};

FloatGrid::Ptr union_of(const Balls& balls) {
  FloatGrid::Ptr grid = openvdb::createLevelSet<FloatGrid>(1);
  openvdb::tools::ParticlesToLevelSet<FloatGrid> raster(*grid);
  // OpenVDB binds a reference to the first point, which must exist
  if (balls.size() > 0) raster.rasterizeSpheres(balls, kRadius);
  raster.finalize(true);
  return grid;
}

/// The balls with their inside filled, as a distance that is exact inside too.
FloatGrid::Ptr filled(FloatGrid::Ptr balls) {
  const auto cavities = openvdb::tools::extractEnclosedRegion(*balls);
  const auto inside = openvdb::tools::sdfInteriorMask(*balls);
  cavities->tree().topologyDifference(inside->tree());
  for (auto part = cavities->tree().cbeginValueOn(); part; ++part) {
    openvdb::CoordBBox box;
    part.getBoundingBox(box);
    balls->fill(box, -balls->background(), false);
  }
  return openvdb::tools::levelSetRebuild(*balls, 0, 3, kInnerBand);
}

/// A morphological closing of the points. The body is where distance < -erosion.
struct Closing {
  FloatGrid::Ptr distance;  ///< to the surface of the filled balls
  float erosion = 0;
  Balls lost;  ///< points with no inside near them
};

/// The depth below the balls' surface that half of the points exceed.
float median_depth(const FloatGrid& distance, const Balls& balls) {
  const openvdb::tools::GridSampler<FloatGrid, openvdb::tools::BoxSampler> sampler(distance);
  std::vector<float> depth;
  for (const openvdb::Vec3R& p : balls.centre) {
    const float d = -sampler.isSample(p);
    if (d < 1.5f * kRadius) depth.push_back(d);  // deeper points lie inside the body
  }
  if (depth.empty()) return kRadius;
  const auto middle = depth.begin() + int64_t(depth.size() / 2);
  std::nth_element(depth.begin(), middle, depth.end());
  return std::clamp(*middle, 0.5f * kRadius, 1.5f * kRadius);
}

Closing closing_of(const Balls& balls) {
  Closing result;
  result.distance = filled(union_of(balls));
  result.erosion = median_depth(*result.distance, balls);
  const auto core = openvdb::tools::sdfInteriorMask(*result.distance, -(result.erosion + kCore));
  openvdb::tools::dilateActiveValues(core->tree(), int(2 * kRadius),
                                     openvdb::tools::NN_FACE_EDGE_VERTEX);
  const auto near_core = core->getConstAccessor();
  for (const openvdb::Vec3R& p : balls.centre)
    if (!near_core.isValueOn(openvdb::Coord::round(p))) result.lost.centre.push_back(p);
  return result;
}

/// Turns the distance into that of the body: eroded, with shells around lost points.
void erode(Closing& closing) {
  const FloatGrid::Ptr lost = union_of(closing.lost);
  const float erosion = closing.erosion;
  openvdb::tree::LeafManager<openvdb::FloatTree> leaves(closing.distance->tree());
  leaves.foreach ([&](openvdb::FloatTree::LeafNodeType& leaf, size_t) {
    const auto ball = lost->getConstAccessor();
    for (auto voxel = leaf.beginValueOn(); voxel; ++voxel) {
      const float eroded = *voxel + erosion;
      const float shell = std::max(*voxel + erosion / 2, ball.getValue(voxel.getCoord()));
      voxel.setValue(std::min(eroded, shell));
    }
  });
}

struct Mesh3 {
  std::vector<openvdb::Vec3s> vertices;
  std::vector<openvdb::Vec3I> triangles;
};

Mesh3 mesh_of(const FloatGrid& grid) {
  Mesh3 mesh;
  std::vector<openvdb::Vec4I> quads;
  openvdb::tools::volumeToMesh(grid, mesh.vertices, mesh.triangles, quads);
  for (const openvdb::Vec4I& q : quads) {
    mesh.triangles.emplace_back(q[0], q[1], q[2]);
    mesh.triangles.emplace_back(q[0], q[2], q[3]);
  }
  // OpenVDB winds faces clockwise as seen from outside
  for (openvdb::Vec3I& t : mesh.triangles) std::swap(t[1], t[2]);
  return mesh;
}

/// Drops parts smaller than a crumb; the largest part always stays.
void drop_crumbs(Mesh3& mesh) {
  std::vector<uint32_t> parent(mesh.vertices.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (const openvdb::Vec3I& t : mesh.triangles)
    for (int k = 1; k < 3; ++k) {
      const uint32_t a = root(t[0]), b = root(t[k]);
      parent[std::max(a, b)] = std::min(a, b);
    }
  std::vector<double> volume(mesh.vertices.size());
  for (const openvdb::Vec3I& t : mesh.triangles) {
    const uint32_t part = root(t[0]);
    const openvdb::Vec3d o(mesh.vertices[part]), a(mesh.vertices[t[0]]), b(mesh.vertices[t[1]]),
        c(mesh.vertices[t[2]]);
    volume[part] += (a - o).dot((b - o).cross(c - o)) / 6;
  }
  const double largest = *std::max_element(volume.begin(), volume.end());
  const double least = std::min(largest, kCrumb);
  std::erase_if(mesh.triangles,
                [&](const openvdb::Vec3I& t) { return std::abs(volume[root(t[0])]) < least; });
}

/// Copies used vertices, scaled from voxels to the numbers of the points, and triangles.
void take(const Mesh3& mesh, const Vec3& origin, double voxel, PointSolid& solid) {
  std::vector<int32_t> place(mesh.vertices.size(), -1);
  std::vector<uint32_t> used;
  solid.triangles = Array<int32_t>(int64_t(mesh.triangles.size()), 3);
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    for (int k = 0; k < 3; ++k) {
      const uint32_t v = mesh.triangles[t][k];
      if (place[v] < 0) {
        place[v] = int32_t(used.size());
        used.push_back(v);
      }
      solid.triangles(int64_t(t), k) = place[v];
    }
  solid.vertices = Array<double>(int64_t(used.size()), 3);
  for (size_t i = 0; i < used.size(); ++i)
    for (int d = 0; d < 3; ++d)
      solid.vertices(int64_t(i), d) = origin[size_t(d)] + voxel * double(mesh.vertices[used[i]][d]);
}

/// The points that belong to the body, and the radius of their balls in their numbers.
struct Sampling {
  std::vector<Vec3> points;
  double radius = 0;
};

Sampling without_floaters(const std::vector<Vec3>& points, double radius, PointSolid& solid) {
  // drop small clusters; balls grow until they are few
  std::vector<uint8_t> kept;
  int64_t floaters = 0;
  for (;; radius *= 1.5) {  // until sparse regions are connected
    kept = large_clusters(points, 2 * radius, kFloaterShare);
    floaters = std::count(kept.begin(), kept.end(), 0);
    if (double(floaters) <= kMostFloaters * double(points.size())) break;
  }
  // the points that stay, and their box
  Sampling result;
  for (size_t i = 0; i < points.size(); ++i)
    if (kept[i]) result.points.push_back(points[i]);
  for (const Vec3& p : result.points) solid.box.add(p);
  if (floaters > 0)
    solid.findings.push_back(
        {"floaters", floaters, "points lie apart from the body in small clusters"});
  result.radius = radius;
  // larger balls for more points than memory allows
  const double excess = double(result.points.size()) / kMaxPoints;
  if (excess > 1) {
    result.radius *= std::sqrt(excess);
    solid.findings.push_back({"coarse", int64_t(result.points.size()),
                              concat("points are more than memory allows for: the spacing is ",
                                     std::sqrt(excess), " times what they would allow")});
  }
  return result;
}

Balls in_voxels(const Sampling& cloud, const Box& box, double voxel, const std::string& place) {
  for (int d = 0; d < 3; ++d)
    ELASTOGEN_CHECK_ASSET(box.extent(d) < kMaxExtent * voxel, place,
                          ": its parts lie further apart than ", kMaxExtent,
                          " voxels of their sampling; split the file");
  Balls balls;
  for (const Vec3& p : cloud.points) {
    const Vec3 q = scaled(minus(p, box.lower), 1 / voxel);
    balls.centre.emplace_back(q[0], q[1], q[2]);
  }
  return balls;
}

void check_finite(const std::vector<Vec3>& points, const std::string& place) {
  for (size_t i = 0; i < points.size(); ++i)
    ELASTOGEN_CHECK_ASSET(
        std::isfinite(points[i][0]) && std::isfinite(points[i][1]) && std::isfinite(points[i][2]),
        place, ": point ", i, " is not finite");
}

double checked_spacing(const std::vector<Vec3>& points, const std::string& place) {
  const double spacing = point_spacing(points);
  ELASTOGEN_CHECK_ASSET(spacing > 0 && std::isfinite(spacing), place, ": ", points.size(),
                        " points at fewer than two places enclose nothing");
  return spacing;
}

}  // namespace

PointSolid solid_of_points(const std::vector<Vec3>& all, const std::string& place, double grain) {
  openvdb::initialize();
  PointSolid solid;
  check_finite(all, place);
  const std::vector<Vec3> points = grain > 0 ? thinned(all, grain) : all;
  const double spacing = checked_spacing(points, place);
  const Sampling cloud = without_floaters(points, kSpacings * spacing, solid);

  // larger balls if the sampling has gaps; if they close nothing, the gaps are real
  Closing closing;
  double voxel = 0;
  for (const double factor : {1.0, 2.0}) {
    const double size = factor * cloud.radius / double(kRadius);
    Closing next = closing_of(in_voxels(cloud, solid.box, size, place));
    const double lost = double(next.lost.size());
    const bool is_closed = lost <= kMostLost * double(cloud.points.size());
    if (factor == 1 || is_closed) closing = std::move(next), voxel = size;
    if (is_closed) break;
  }
  const auto lost = int64_t(closing.lost.size());
  if (double(lost) > 0.01 * double(cloud.points.size()))
    solid.findings.push_back({"shell", lost,
                              concat("of ", points.size(),
                                     " points enclose nothing: there the solid is a shell of "
                                     "thickness ",
                                     double(closing.erosion) * voxel, " in the file's numbers")});
  solid.is_shell = double(lost) > 0.9 * double(cloud.points.size());
  erode(closing);
  Mesh3 mesh = mesh_of(*closing.distance);
  ELASTOGEN_CHECK_ASSET(!mesh.triangles.empty(), place, ": its points enclose nothing");
  drop_crumbs(mesh);
  take(mesh, solid.box.lower, voxel, solid);
  return solid;
}

}  // namespace elastogen
