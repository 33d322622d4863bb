// SPDX-License-Identifier: Apache-2.0
#include "voxelize/apart.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <limits>

namespace elastogen {
namespace {

constexpr int32_t kStep = 64, kGap = 32;  // [voxels]

/// The triangles of one part, and the vertices that they use.
Surface surface_of(const WeldedMesh& welded, const std::vector<int32_t>& triangles) {
  Surface surface;
  std::vector<int32_t> used;
  for (const int32_t t : triangles)
    used.insert(used.end(), welded.triangles.row(t), welded.triangles.row(t) + 3);
  std::ranges::sort(used);
  used.erase(std::unique(used.begin(), used.end()), used.end());
  surface.vertices = Array<double>(int64_t(used.size()), 3);
  for (size_t v = 0; v < used.size(); ++v) {
    const double* x = welded.vertices.row(used[v]);
    std::copy_n(x, 3, surface.vertices.row(int64_t(v)));
    surface.box.add({x[0], x[1], x[2]});
  }
  surface.triangles = Array<int32_t>(int64_t(triangles.size()), 3);
  for (size_t t = 0; t < triangles.size(); ++t)
    for (int k = 0; k < 3; ++k)
      surface.triangles(int64_t(t), k) =
          int32_t(std::ranges::lower_bound(used, welded.triangles(triangles[t], k)) - used.begin());
  return surface;
}

/// First and last voxel along x.
std::pair<int32_t, int32_t> range_along_x(const CutBody& body) {
  std::pair<int32_t, int32_t> range = {std::numeric_limits<int32_t>::max(),
                                       std::numeric_limits<int32_t>::min()};
  const Array<int32_t> coords = body.voxels();
  for (int64_t v = 0; v < coords.rows(); ++v) {
    range.first = std::min(range.first, coords(v, 0));
    range.second = std::max(range.second, coords(v, 0));
  }
  return range;
}

}  // namespace

std::vector<CutBody> cut_parts(const CutBody& whole, const Parts& parts,
                               const VoxelizeOptions& options) {
  std::vector<std::vector<int32_t>> triangles(size_t(parts.count));
  for (int64_t t = 0; t < whole.welded.triangles.rows(); ++t)
    triangles[size_t(parts.of[size_t(t)])].push_back(int32_t(t));
  std::vector<CutBody> bodies;
  for (const std::vector<int32_t>& of_part : triangles)
    bodies.push_back(cut_body(surface_of(whole.welded, of_part), options, whole.lattice));
  return bodies;
}

std::vector<int32_t> shifts_apart(const std::vector<CutBody>& bodies) {
  std::vector<int32_t> shifts;
  int64_t next = std::numeric_limits<int32_t>::min();
  for (const CutBody& body : bodies) {
    const auto [first, last] = range_along_x(body);
    const int64_t steps = std::max<int64_t>(0, (next - first + kStep - 1) / kStep);
    const int64_t end = last + steps * kStep;
    if (end >= kLatticeLimit - 2)
      throw Error(concat("--part-pieces: ", bodies.size(), " parts do not fit side by side on the ",
                         "lattice of 2^20 voxels along x; take fewer --voxels"),
                  ErrorKind::kResources);
    shifts.push_back(int32_t(steps * kStep));
    next = end + kGap + 1;
  }
  return shifts;
}

void set_parts(const std::vector<CutBody>& bodies, std::vector<int32_t> shift, VoxelGrid& grid) {
  std::vector<int32_t> first;  // first voxel of each part along x
  for (size_t k = 0; k < bodies.size(); ++k)
    first.push_back(range_along_x(bodies[k]).first + shift[k]);
  grid.part = Array<int32_t>(grid.voxel_count());
  grid.part_shift = std::move(shift);
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    const auto next = std::ranges::upper_bound(first, grid.voxel_coord(v, 0));
    grid.part(v) = int32_t(next - first.begin()) - 1;
    for (int c = 0; c < 8; ++c) {
      const int32_t n = grid.corners(v, c);
      grid.rest(n, 0) = grid.origin[0] + grid.h * (grid.node_coord(n, 0) - grid.shift_of(v));
    }
  }
}

Array<int32_t> part_of_triangles(const Surface& surface, const WeldedMesh& welded,
                                 const Parts& parts) {
  std::vector<int32_t> of_vertex(size_t(welded.vertices.rows()), -1);
  for (int64_t t = 0; t < welded.triangles.rows(); ++t)
    for (int k = 0; k < 3; ++k) of_vertex[size_t(welded.triangles(t, k))] = parts.of[size_t(t)];
  Array<int32_t> result(surface.triangles.rows());
  for (int64_t t = 0; t < result.rows(); ++t) {
    result(t) = -1;
    for (int k = 0; k < 3; ++k) {
      const int32_t v = welded.welded_of[size_t(surface.triangles(t, k))];
      if (v >= 0) result(t) = std::max(result(t), of_vertex[size_t(v)]);
    }
  }
  return result;
}

}  // namespace elastogen
