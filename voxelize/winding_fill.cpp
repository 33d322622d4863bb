// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "voxelize/fill_fraction.hpp"
#include "voxelize/winding_number.hpp"

#include <openvdb/openvdb.h>
#include <openvdb/tree/ValueAccessor.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace elastogen {
namespace {

constexpr int kLines = 8;       // lines across a voxel
constexpr int64_t kCells = 16;  // cells of one parallel task

using Triangle = WindingNumber::Triangle;

/// Place where a line crosses a triangle, and the step of the winding number there.
struct Crossing {
  double place;
  int step;
  bool operator<(const Crossing& other) const { return place < other.place; }
};

double area2(const Vec3& a, const Vec3& b, const Vec3& p, int u, int v) {
  return (b[u] - a[u]) * (p[v] - a[v]) - (b[v] - a[v]) * (p[u] - a[u]);
}

/// Whether p is left of a b in the plane of u and v. A point on the edge is left of one direction
/// only, and both triangles of an edge compute the same number.
bool left_of(const Vec3& a, const Vec3& b, const Vec3& p, int u, int v) {
  if (std::tie(a[u], a[v]) < std::tie(b[u], b[v])) return area2(a, b, p, u, v) >= 0;
  return !(area2(b, a, p, u, v) >= 0);
}

/// Crossings with the line through p along an axis, in order.
void find_crossings(const std::vector<Triangle>& triangles, const Vec3& p, int axis,
                    std::vector<Crossing>& result) {
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;
  result.clear();
  for (const auto& [corner] : triangles) {
    const bool left = left_of(corner[0], corner[1], p, u, v);
    if (left != left_of(corner[1], corner[2], p, u, v) ||
        left != left_of(corner[2], corner[0], p, u, v))
      continue;
    double place = 0, sum = 0;
    for (int k = 0; k < 3; ++k) {
      const double weight = area2(corner[(k + 1) % 3], corner[(k + 2) % 3], p, u, v);
      place += weight * corner[k][axis];
      sum += weight;
    }
    if (sum != 0) result.push_back({place / sum, left ? -1 : 1});
  }
  std::sort(result.begin(), result.end());
}

/// Change of the winding number from coordinate a to b of the line.
int step_between(const std::vector<Crossing>& crossings, double a, double b) {
  int sum = 0;
  for (const Crossing& c : crossings) {
    if (c.place > a && c.place <= b) sum += c.step;
    if (c.place > b && c.place <= a) sum -= c.step;
  }
  return sum;
}

bool is_inside(double w) {
  return std::abs(w) > 0.5;
}

/// Adds the inside part of a line through p to the voxel's moments.
void integrate_line(const std::vector<Crossing>& crossings, double w, const Vec3& p, int axis,
                    double* moment) {
  // w is known at p; move it to the lower face
  w -= step_between(crossings, 0, p[axis]);
  double from = 0, length = 0, middle = 0;  // int dt and int t dt over the inside
  const auto take = [&](double to) {
    if (is_inside(w)) {
      length += to - from;
      middle += (to * to - from * from) / 2;
    }
    from = to;
  };
  for (const Crossing& c : crossings) {
    if (c.place <= 0 || c.place > 1) continue;
    take(c.place);
    w += c.step;
  }
  take(1);
  for (int c = 0; c < 8; ++c) {
    double weight = 1.0 / (kLines * kLines);
    for (int d = 0; d < 3; ++d)
      if (d != axis) weight *= c >> d & 1 ? p[d] : 1 - p[d];
    moment[c] += weight * (c >> axis & 1 ? middle : length - middle);
  }
}

/// Fills the moments of one cell from its triangles, in coordinates of the voxel.
void sample_cell(const std::vector<Triangle>& triangles, const Coord& cell,
                 const WindingNumber& winding_number, double* moment) {
  // lines run along the axis that the surface faces most
  Vec3 facing = {};
  for (const auto& [corner] : triangles) {
    const Vec3 normal = cross(minus(corner[1], corner[0]), minus(corner[2], corner[0]));
    for (int d = 0; d < 3; ++d) facing[d] += std::abs(normal[d]);
  }
  const int axis =
      static_cast<int>(std::max_element(facing.begin(), facing.end()) - facing.begin());
  const int u = (axis + 1) % 3, v = (axis + 2) % 3;

  // one evaluation of w, carried over the cell by crossings along v, along u, then along the lines
  constexpr double kFirst = 0.5 / kLines;
  const double w = winding_number({cell[0] + kFirst, cell[1] + kFirst, cell[2] + kFirst});
  std::vector<Crossing> along_v, along_u, along_line;
  Vec3 p = {kFirst, kFirst, kFirst};
  find_crossings(triangles, p, v, along_v);
  for (int j = 0; j < kLines; ++j) {
    p[v] = (j + 0.5) / kLines;
    p[u] = kFirst;
    const double w_v = w + step_between(along_v, kFirst, p[v]);
    find_crossings(triangles, p, u, along_u);
    for (int i = 0; i < kLines; ++i) {
      p[u] = (i + 0.5) / kLines;
      find_crossings(triangles, p, axis, along_line);
      integrate_line(along_line, w_v + step_between(along_u, kFirst, p[u]), p, axis, moment);
    }
  }
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

Triangle triangle_at(const LatticeMesh& mesh, int32_t t, const Coord& cell) {
  Triangle result;
  for (int k = 0; k < 3; ++k)
    for (int d = 0; d < 3; ++d)
      result.corner[k][d] = mesh.vertices[mesh.triangles[t][k]][d] - cell[d];
  return result;
}

}  // namespace

Fill winding_fill(const LatticeMesh& mesh, const SurfaceCells& cells, int64_t max_voxels) {
  std::vector<Triangle> solid;
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    if (mesh.role[t] == Role::kSolid)
      solid.push_back(triangle_at(mesh, static_cast<int32_t>(t), {0, 0, 0}));
  const WindingNumber winding_number(std::move(solid));

  Fill fill;
  fill.moment = Array<double>(cells.count(), 8);
  const auto sample = [&](int64_t c) {
    std::vector<Triangle> local;
    for (int64_t i = cells.first[c]; i < cells.first[c + 1]; ++i)
      if (mesh.role[cells.triangle[i]] == Role::kSolid)
        local.push_back(triangle_at(mesh, cells.triangle[i], cells.coord[c]));
    sample_cell(local, cells.coord[c], winding_number, fill.moment.row(c));
  };
  for_each(cells.count(), sample, kCells);
  fill.full = flood(cells, winding_number, max_voxels);
  fill.volume = static_cast<double>(fill.full.size());
  for (int64_t i = 0; i < fill.moment.size(); ++i) fill.volume += fill.moment.data()[i];
  return fill;
}

}  // namespace elastogen
