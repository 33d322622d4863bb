// SPDX-License-Identifier: Apache-2.0
// The inside of a surface along 8 x 8 lines through a voxel, in whose coordinates (0..1 along each
// edge) everything here is.

#pragma once

#include "voxelize/surface_cells.hpp"
#include "voxelize/winding_number.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

inline constexpr int kLines = 8;  ///< across a voxel

/// Place where a line crosses a triangle, and the step of the winding number there.
struct Crossing {
  double place;
  int step;
  bool operator<(const Crossing& other) const { return place < other.place; }
};
using Crossings = std::vector<Crossing>;

using LocalTriangles = std::vector<WindingNumber::Triangle>;

/// The triangles of a surface cell that bound a solid.
LocalTriangles solid_triangles(const LatticeMesh& mesh, const SurfaceCells& cells, int64_t cell);

/// Crossings with the line through p along an axis, in order.
void find_crossings(const LocalTriangles& triangles, const Vec3& p, int axis, Crossings& result);

/// Change of the winding number from coordinate a to b of the line.
int step_between(const Crossings& crossings, double a, double b);

inline bool is_inside(double w) {
  return std::abs(w) > 0.5;
}

/// The middle line of those across a box.
inline Vec3 first_line(const Box& box) {
  Vec3 p;
  for (size_t d = 0; d < 3; ++d) p[d] = box.lower[d] + box.extent(int(d)) * 0.5 / kLines;
  return p;
}

/// Calls line(crossings, w, p) for lines along an axis that are spread over a box; w is the winding
/// number at p, carried from that at first_line(box).
template <class Line>
void for_each_line(const LocalTriangles& triangles, const Box& box, int axis, double first_w,
                   const Line& line) {
  const auto u = size_t((axis + 1) % 3), v = size_t((axis + 2) % 3);
  const Vec3 first = first_line(box);
  Crossings along_v, along_u, along_line;
  Vec3 p = first;
  find_crossings(triangles, p, int(v), along_v);
  for (int j = 0; j < kLines; ++j) {
    p[v] = box.lower[v] + box.extent(int(v)) * (j + 0.5) / kLines;
    p[u] = first[u];
    const double w = first_w + step_between(along_v, first[v], p[v]);
    find_crossings(triangles, p, int(u), along_u);
    for (int i = 0; i < kLines; ++i) {
      p[u] = box.lower[u] + box.extent(int(u)) * (i + 0.5) / kLines;
      find_crossings(triangles, p, axis, along_line);
      line(along_line, w + step_between(along_u, first[u], p[u]), p);
    }
  }
}

/// Calls take(from, to) for the parts of a line within the voxel that lie inside.
template <class Take>
void for_each_inside(const Crossings& crossings, double w, const Vec3& p, int axis,
                     const Take& take) {
  // w is known at p; move it to the lower face
  w -= step_between(crossings, 0, p[size_t(axis)]);
  double from = 0;
  const auto end = [&](double to) {
    if (is_inside(w)) take(from, to);
    from = to;
  };
  for (const Crossing& c : crossings) {
    if (c.place <= 0 || c.place > 1) continue;
    end(c.place);
    w += c.step;
  }
  end(1);
}

/// int dt and int t dt over parts of a line.
struct LineSums {
  double length = 0, middle = 0;

  void add(double from, double to) {
    length += to - from;
    middle += (to * to - from * from) / 2;
  }
  /// Adds int N_c along them, times a weight, to moments, (8). @param p  a point of the line.
  void add_to(double* moment, const Vec3& p, int axis, double weight) const {
    for (int c = 0; c < 8; ++c) {
      double share = weight;
      for (int d = 0; d < 3; ++d)
        if (d != axis) share *= c >> d & 1 ? p[size_t(d)] : 1 - p[size_t(d)];
      moment[c] += share * (c >> axis & 1 ? middle : length - middle);
    }
  }
};

}  // namespace elastogen
