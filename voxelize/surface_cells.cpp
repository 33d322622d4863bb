// SPDX-License-Identifier: Apache-2.0
#include "voxelize/surface_cells.hpp"

#include "core/parallel.hpp"
#include "core/parallel_sort.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

namespace elastogen {
namespace {

constexpr double kDeep = 1e-5;     // parts closer to a face of the voxel do not touch the voxel
constexpr double kMinArea = 1e-6;  // least area of a part in a lattice plane
constexpr int64_t kTriangles = 8;  // triangles of one parallel task

/// A convex part of a triangle: at most nine corners, and some more for rounding.
struct Polygon {
  int corners = 0;
  std::array<Vec3, 24> corner;
  void add(const Vec3& p) {
    if (corners < static_cast<int>(corner.size())) corner[corners++] = p;
  }
};

/// The part of a triangle in one voxel.
struct Part {
  uint64_t key;  ///< z, y, x of the voxel in one number
  int32_t triangle;
  uint8_t touched, side;
  double ahead[8], flux[4], area[8];
};

uint64_t row_key(const Coord& c) {
  constexpr uint64_t kOffset = uint64_t{1} << 20;
  return (c[2] + kOffset) << 42 | (c[1] + kOffset) << 21 | (c[0] + kOffset);
}

Coord coord_of(uint64_t key) {
  constexpr int32_t kOffset = 1 << 20, kMask = (1 << 21) - 1;
  return {static_cast<int32_t>(key & kMask) - kOffset,
          static_cast<int32_t>(key >> 21 & kMask) - kOffset,
          static_cast<int32_t>(key >> 42) - kOffset};
}

/// Cuts at the plane where coordinate d is `plane`; corners in the plane belong to both parts.
void cut(const Polygon& whole, int d, double plane, Polygon& lower, Polygon& upper) {
  lower.corners = upper.corners = 0;
  for (int i = 0; i < whole.corners; ++i) {
    const Vec3 &a = whole.corner[i], &b = whole.corner[(i + 1) % whole.corners];
    if (a[d] <= plane) lower.add(a);
    if (a[d] >= plane) upper.add(a);
    if ((a[d] < plane && b[d] > plane) || (a[d] > plane && b[d] < plane)) {
      Vec3 p = plus(a, scaled(minus(b, a), (plane - a[d]) / (b[d] - a[d])));
      p[d] = plane;
      lower.add(p);
      upper.add(p);
    }
  }
}

/// Adds the integrals over one triangle of a part, in coordinates of the voxel.
void integrate(const Vec3& a, const Vec3& b, const Vec3& c, Part& part) {
  // six points of quadrature, exact for polynomials of degree four
  constexpr double kNear[2] = {0.445948490915964886, 0.0915762135097707435};
  constexpr double kWeight[2] = {0.223381589678011466, 0.109951743655321868};
  const Vec3 normal = scaled(cross(minus(b, a), minus(c, a)), 0.5);
  const double area = norm(normal);
  for (int q = 0; q < 6; ++q) {
    const double u = kNear[q / 3], w = kWeight[q / 3];
    double barycentric[3] = {u, u, u};
    barycentric[q % 3] = 1 - 2 * u;
    Vec3 p;
    for (int d = 0; d < 3; ++d)
      p[d] = barycentric[0] * a[d] + barycentric[1] * b[d] + barycentric[2] * c[d];
    const double x[2] = {1 - p[0], p[0]};
    const double ahead[2] = {x[0] * x[0] / 2, (1 - x[1] * x[1]) / 2};  // int_x^1 of both X_i
    for (int jk = 0; jk < 4; ++jk) {
      const double yz = (jk & 1 ? p[1] : 1 - p[1]) * (jk & 2 ? p[2] : 1 - p[2]);
      part.flux[jk] -= w * normal[0] * yz;
      for (int i = 0; i < 2; ++i) {
        part.ahead[i + 2 * jk] -= w * normal[0] * yz * ahead[i];
        part.area[i + 2 * jk] += w * area * yz * x[i];
      }
    }
  }
}

/// The integrals over the part of a triangle that lies in a voxel.
Part make_part(const Polygon& polygon, const Coord& cell, int32_t triangle, bool bounds) {
  Part part = {row_key(cell), triangle, 1, 0, {}, {}, {}};
  Polygon local;
  Box box;
  for (int i = 0; i < polygon.corners; ++i) {
    const Vec3& p = polygon.corner[i];
    local.add({p[0] - cell[0], p[1] - cell[1], p[2] - cell[2]});
    box.add(local.corner[i]);
  }
  for (int i = 2; i < local.corners; ++i)
    integrate(local.corner[0], local.corner[i - 1], local.corner[i], part);
  if (!bounds) std::fill(part.ahead, part.ahead + 8, 0), std::fill(part.flux, part.flux + 4, 0);

  // parts that stay within a face do not touch the voxel
  double area = 0;
  for (const double a : part.area) area += a;
  for (int d = 0; d < 3; ++d)
    for (int upper = 0; upper < 2; ++upper)
      if (upper ? box.lower[d] > 1 - kDeep : box.upper[d] < kDeep) {
        part.touched = 0;
        if (area > kMinArea) part.side |= 1 << (2 * d + upper);
      }
  return part;
}

/// Halves a polygon at lattice planes until each part lies within one voxel.
template <class Emit>
void split(const Polygon& polygon, const Emit& emit) {
  Coord lower, upper;
  Box box;
  for (int i = 0; i < polygon.corners; ++i) box.add(polygon.corner[i]);
  int axis = 0;
  for (int d = 0; d < 3; ++d) {
    lower[d] = static_cast<int32_t>(std::floor(box.lower[d]));
    upper[d] = std::max(lower[d], static_cast<int32_t>(std::ceil(box.upper[d])) - 1);
    if (upper[d] - lower[d] > upper[axis] - lower[axis]) axis = d;
  }
  if (lower == upper) return emit(polygon, lower);
  Polygon parts[2];
  cut(polygon, axis, lower[axis] + (upper[axis] - lower[axis] + 1) / 2, parts[0], parts[1]);
  for (const Polygon& part : parts)
    if (part.corners > 0) split(part, emit);
}

/// All parts, sorted by voxel and triangle.
std::vector<Part> find_parts(const LatticeMesh& mesh) {
  // cut blocks of triangles side by side
  const auto triangles = int64_t(mesh.triangles.size());
  std::vector<std::vector<Part>> lists(size_t((triangles + kTriangles - 1) / kTriangles));
  const auto cut = [&](int64_t begin, int64_t end) {
    std::vector<Part>& list = lists[size_t(begin / kTriangles)];
    for (int64_t t = begin; t < end; ++t) {
      Polygon triangle;
      for (const int32_t v : mesh.triangles[size_t(t)]) triangle.add(mesh.vertices[v]);
      split(triangle, [&](const Polygon& polygon, const Coord& cell) {
        list.push_back(make_part(polygon, cell, static_cast<int32_t>(t),
                                 mesh.role[size_t(t)] == Role::kSolid));
      });
    }
  };
  for_blocks(triangles, cut, kTriangles);
  // sort references, then copy the parts once
  std::vector<const Part*> order;
  for (const std::vector<Part>& list : lists)
    for (const Part& part : list) order.push_back(&part);
  parallel_sort(order.begin(), order.end(), [](const Part* a, const Part* b) {
    return std::tie(a->key, a->triangle) < std::tie(b->key, b->triangle);
  });
  std::vector<Part> parts(order.size());
  for_each(int64_t(order.size()), [&](int64_t i) { parts[size_t(i)] = *order[size_t(i)]; });
  return parts;
}

}  // namespace

SurfaceCells cut_surface(const LatticeMesh& mesh) {
  // one cell for each voxel with parts
  const std::vector<Part> parts = find_parts(mesh);
  SurfaceCells cells;
  for (size_t i = 0; i < parts.size(); ++i) {
    if (i == 0 || parts[i].key != parts[i - 1].key) {
      cells.coord.push_back(coord_of(parts[i].key));
      cells.first.push_back(static_cast<int64_t>(i));
    }
    cells.triangle.push_back(parts[i].triangle);
  }
  cells.first.push_back(static_cast<int64_t>(parts.size()));

  // sums over the parts of each cell, in their order
  const int64_t count = cells.count();
  cells.ahead = Array<double>(count, 8);
  cells.flux = Array<double>(count, 4);
  cells.area = Array<double>(count, 8);
  cells.sheet_area.assign(count, 0);
  cells.touched.assign(count, 0);
  cells.side.assign(count, 0);
  cells.sheet.assign(count, 0);
  for_each(count, [&](int64_t c) {
    for (int64_t i = cells.first[c]; i < cells.first[c + 1]; ++i) {
      for (int k = 0; k < 8; ++k) cells.ahead(c, k) += parts[i].ahead[k];
      for (int k = 0; k < 4; ++k) cells.flux(c, k) += parts[i].flux[k];
      for (int k = 0; k < 8; ++k) cells.area(c, k) += parts[i].area[k];
      if (mesh.role[parts[i].triangle] == Role::kSheet)
        for (int k = 0; k < 8; ++k) cells.sheet_area[c] += parts[i].area[k];
      cells.touched[c] |= parts[i].touched;
      cells.side[c] |= parts[i].side;
      cells.sheet[c] |= parts[i].touched && mesh.role[parts[i].triangle] == Role::kSheet;
    }
  });
  return cells;
}

}  // namespace elastogen
