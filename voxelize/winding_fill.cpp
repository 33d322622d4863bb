// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "voxelize/cell_lines.hpp"
#include "voxelize/fill_fraction.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tree/ValueAccessor.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int64_t kCells = 16;  // cells of one parallel task

/// Fills the moments of one cell from its triangles, in coordinates of the voxel.
void sample_cell(const LocalTriangles& triangles, const Coord& cell,
                 const WindingNumber& winding_number, double* moment) {
  // lines run along the axis that the surface faces most
  Vec3 facing = {};
  for (const auto& [corner] : triangles) {
    const Vec3 normal = cross(minus(corner[1], corner[0]), minus(corner[2], corner[0]));
    for (int d = 0; d < 3; ++d) facing[d] += std::abs(normal[d]);
  }
  const int axis =
      static_cast<int>(std::max_element(facing.begin(), facing.end()) - facing.begin());

  // one evaluation of w, carried over the cell by crossings
  constexpr double kFirst = 0.5 / kLines;
  const double w = winding_number({cell[0] + kFirst, cell[1] + kFirst, cell[2] + kFirst});
  for_each_line(triangles, {{0, 0, 0}, {1, 1, 1}}, axis, w,
                [&](const Crossings& crossings, double at, const Vec3& p) {
                  LineSums sums;
                  for_each_inside(crossings, at, p, axis,
                                  [&](double from, double to) { sums.add(from, to); });
                  sums.add_to(moment, p, axis, 1.0 / (kLines * kLines));
                });
}

/// Voxels without surface whose centre is inside, by a flood from the surface.
std::vector<Run> flood(const SurfaceCells& cells, const WindingNumber& winding_number,
                       int64_t max_voxels) {
  // cells with surface need no answer
  openvdb::MaskTree seen;
  openvdb::tree::ValueAccessor<openvdb::MaskTree> accessor(seen);
  for (const Coord& c : cells.coord) accessor.setValueOn({c[0], c[1], c[2]});

  // neighbours of the front that nobody has seen
  std::vector<Run> inside;
  std::vector<Coord> front = cells.coord, next;
  while (!front.empty()) {
    next.clear();
    for (const Coord& c : front)
      for (int side = 0; side < 6; ++side) {
        Coord n = c;
        n[side >> 1] += side & 1 ? 1 : -1;
        if (accessor.isValueOn({n[0], n[1], n[2]})) continue;
        accessor.setValueOn({n[0], n[1], n[2]});
        next.push_back(n);
      }
    // ask the winding number at their centres
    std::vector<uint8_t> keep(next.size());
    const auto ask = [&](int64_t i) {
      const Coord& c = next[size_t(i)];
      keep[size_t(i)] = is_inside(winding_number({c[0] + 0.5, c[1] + 0.5, c[2] + 0.5}));
    };
    for_each(int64_t(next.size()), ask, kCells);
    // those inside are the next front
    front.clear();
    for (size_t i = 0; i < next.size(); ++i)
      if (keep[i]) front.push_back(next[i]);
    for (const Coord& c : front) inside.push_back({c, 1});
    if (static_cast<int64_t>(inside.size()) > max_voxels)
      throw Error(concat("the inside has more than ", max_voxels, " voxels"),
                  ErrorKind::kResources);
  }
  return inside;
}

/// All triangles that bound a solid.
LocalTriangles all_solid(const LatticeMesh& mesh) {
  LocalTriangles solid;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (mesh.role[t] != Role::kSolid) continue;
    WindingNumber::Triangle& triangle = solid.emplace_back();
    for (int k = 0; k < 3; ++k) triangle.corner[k] = mesh.vertices[size_t(mesh.triangles[t][k])];
  }
  return solid;
}

}  // namespace

Fill winding_fill(const LatticeMesh& mesh, const SurfaceCells& cells, int64_t max_voxels) {
  const WindingNumber winding_number(all_solid(mesh));

  Fill fill;
  fill.moment = Array<double>(cells.count(), 8);
  const auto sample = [&](int64_t c) {
    sample_cell(solid_triangles(mesh, cells, c), cells.coord[c], winding_number,
                fill.moment.row(c));
  };
  for_each(cells.count(), sample, kCells);
  fill.full = flood(cells, winding_number, max_voxels);
  fill.volume = static_cast<double>(fill.full.size());
  for (int64_t i = 0; i < fill.moment.size(); ++i) fill.volume += fill.moment.data()[i];
  return fill;
}

}  // namespace elastogen
