// SPDX-License-Identifier: Apache-2.0
#include "voxelize/body.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "voxelize/from_points.hpp"
#include "voxelize/from_splats.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kTail = 0.02;  // share of the points that may be floaters on each side

/// Longest edge of the box of all points except the outermost along each axis.
double bulk_edge(const std::vector<Vec3>& points) {
  double longest = 0;
  std::vector<double> x;
  for (size_t d = 0; d < 3; ++d) {
    x.clear();
    for (const Vec3& p : points)
      if (std::isfinite(p[d])) x.push_back(p[d]);
    if (x.empty()) continue;
    const auto tail = int64_t(kTail * double(x.size()));
    std::nth_element(x.begin(), x.begin() + tail, x.end());
    const double low = x[size_t(tail)];
    std::nth_element(x.begin(), x.end() - 1 - tail, x.end());
    longest = std::max(longest, x[x.size() - 1 - size_t(tail)] - low);
  }
  return longest;
}

/// A quarter of a voxel, in the numbers of the points.
double grain_of(const Asset& asset, const std::vector<Vec3>& points, double size,
                const VoxelizeOptions& resolution) {
  const double longest = bulk_edge(points);
  const double scale = size > 0 ? size / longest : asset.unit > 0 ? asset.unit : 1;
  const double h = resolution.h > 0 ? resolution.h / scale : longest / resolution.voxels;
  return std::isfinite(h) ? h / 4 : 0;
}

/// Mean thickness of a shell: twice its volume over its area.
double mean_thickness(const Surface& surface) {
  double volume = 0, area = 0;
  for (int64_t t = 0; t < surface.triangles.rows(); ++t) {
    Vec3 x[3];
    for (int k = 0; k < 3; ++k)
      std::copy_n(surface.vertices.row(surface.triangles(t, k)), 3, x[k].begin());
    volume += dot(x[0], cross(x[1], x[2])) / 6;
    area += norm(cross(minus(x[1], x[0]), minus(x[2], x[0]))) / 2;
  }
  return 2 * volume / area;
}

/// A body with the surface of a solid, scaled to metres.
/// @param box  its longest edge becomes `size`.
Body scaled_body(const Asset& asset, const PointSolid& solid, const Box& box,
                 const std::vector<Vec3>& carried, double size) {
  // scale: --size, else the unit of the file
  Body body;
  body.is_asset = false;
  Surface& surface = body.surface;
  const double longest = std::max({box.extent(0), box.extent(1), box.extent(2)});
  surface.scale = size > 0 ? size / longest : asset.unit > 0 ? asset.unit : 1;
  // the surface, its numbers from its own middle
  surface.vertices = solid.vertices;
  surface.triangles = solid.triangles;
  surface.material = Array<int32_t>(solid.triangles.rows());
  surface.material.fill(-1);
  for (int64_t v = 0; v < surface.vertices.rows(); ++v) {
    double* x = surface.vertices.row(v);
    for (int d = 0; d < 3; ++d) x[d] *= surface.scale;
    surface.box.add({x[0], x[1], x[2]});
  }
  settle(surface);
  // the points that it carries
  body.carried = Array<double>(int64_t(carried.size()), 3);
  for (int64_t p = 0; p < body.carried.rows(); ++p)
    for (int d = 0; d < 3; ++d) {
      body.carried(p, d) =
          surface.scale * carried[size_t(p)][size_t(d)] - surface.box.origin[size_t(d)];
      ELASTOGEN_CHECK_ASSET(std::isfinite(body.carried(p, d)), asset.path, ": point ", p,
                            " is not finite once it is scaled");
    }
  // findings and thickness
  body.findings = solid.findings;
  if (solid.is_shell) body.shell = mean_thickness(surface);
  return body;
}

}  // namespace

Body make_body(const Asset& asset, double size, const VoxelizeOptions& resolution) {
  ELASTOGEN_CHECK(size >= 0 && std::isfinite(size), "the size must be positive, got ", size);
  if (asset.points) {
    const std::vector<Vec3>& points = asset.points->position;
    const double grain = grain_of(asset, points, size, resolution);
    const PointSolid solid = solid_of_points(points, asset.path, grain);
    return scaled_body(asset, solid, solid.box, points, size);
  }
  if (asset.splats) {
    const std::vector<Vec3>& centres = asset.splats->position;
    const double grain = grain_of(asset, centres, size, resolution);
    SplatSamples samples = sample_splats(*asset.splats, asset.path, grain);
    const PointSolid solid = solid_of_points(samples.points, asset.path, grain);
    const Box box = shown_box(*asset.splats, solid.box, 4 * grain);
    Body body = scaled_body(asset, solid, box, centres, size);
    body.findings.insert(body.findings.begin(), samples.findings.begin(), samples.findings.end());
    return body;
  }
  Body body;
  body.surface = pose_surface(asset, size);
  body.carried = body.surface.vertices;
  return body;
}

}  // namespace elastogen
