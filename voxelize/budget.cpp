// SPDX-License-Identifier: Apache-2.0
#include "voxelize/budget.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

/// Number of cells of edge h that a box can meet.
double cells(const Box& box, double h) {
  double product = 1;
  for (int d = 0; d < 3; ++d) product *= std::floor(box.extent(d) / h) + 2;
  return product;
}

int64_t largest_count(const VoxelizeOptions& options) {
  ELASTOGEN_CHECK(options.max_voxels > 0, "max_voxels must be positive, got ", options.max_voxels);
  ELASTOGEN_CHECK(options.max_memory >= 0, "max_memory must not be negative, got ",
                  options.max_memory);
  if (options.max_memory == 0) return options.max_voxels;
  return std::min(options.max_voxels, options.max_memory / options.bytes_per_voxel);
}

[[noreturn]] void refuse(double voxels, double h, const VoxelizeOptions& options, double fitting) {
  throw Error(concat("h = ", h, " m needs about ", voxels, " voxels and ",
                     voxels * double(options.bytes_per_voxel) / 1e9, " GB; the budget is ",
                     largest_count(options), " voxels. h = ", fitting, " m would fit"),
              ErrorKind::kResources);
}

}  // namespace

double estimate_voxels(const WeldedMesh& mesh, double h) {
  Box whole;
  double touched = 0;
  for (int64_t t = 0; t < mesh.triangles.rows(); ++t) {
    Vec3 p[3];
    Box box;
    for (int k = 0; k < 3; ++k) {
      for (int d = 0; d < 3; ++d) p[k][d] = mesh.vertices(mesh.triangles(t, k), d) / h;
      box.add(p[k]);
      whole.add(p[k]);
    }
    const Vec3 a = minus(p[1], p[0]), b = minus(p[2], p[0]);
    const double edges = norm(a) + norm(b) + norm(minus(p[2], p[1]));
    touched += std::min(cells(box, 1), norm(cross(a, b)) + 2 * edges + 8);
  }
  const double volume = std::abs(mesh.volume) / h / h / h;
  return std::min(cells(whole, 1), volume + touched);
}

void check_budget(const WeldedMesh& mesh, double h, const VoxelizeOptions& options) {
  const auto limit = static_cast<double>(largest_count(options));
  const double needed = estimate_voxels(mesh, h);
  if (needed <= limit) return;
  double fitting = h;
  for (double count = needed; count > limit; count = estimate_voxels(mesh, fitting)) {
    fitting *= std::max(1.01, std::cbrt(count / std::max(limit, 1.0)));
    if (count <= 8) break;  // no edge fits so small a budget
  }
  refuse(needed, h, options, 1.001 * fitting);
}

void check_budget(int64_t voxels, double h, const VoxelizeOptions& options) {
  const int64_t limit = largest_count(options);
  if (voxels <= limit) return;
  const auto needed = static_cast<double>(voxels);
  refuse(needed, h, options,
         1.05 * h * std::cbrt(needed / static_cast<double>(std::max<int64_t>(limit, 1))));
}

}  // namespace elastogen
