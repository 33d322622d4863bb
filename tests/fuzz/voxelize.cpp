// SPDX-License-Identifier: Apache-2.0
// Bytes as triangles: 4 to 19 corners on a lattice or anywhere. Every surface gives voxels whose
// fills lie in (0, 1] and whose means sum to 1, or an Error.

#include "voxelize/voxelize.hpp"

#include "tests/fuzz/harness.hpp"
#include "voxelize/embedding.hpp"
#include "voxelize/labels.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace elastogen {
namespace {

using fuzz::require;

/// Coordinates of two bytes each; the first byte decides how coarse they are.
Asset asset_of(const uint8_t* data, size_t size) {
  const double step = std::pow(2.0, data[0] % 8);
  Asset asset;
  Mesh& mesh = asset.meshes.emplace_back();
  asset.nodes.push_back({.name = "", .parent = -1, .mesh = 0});
  TriangleGroup& group = mesh.groups.emplace_back();
  size_t at = 2;
  for (int v = 0; v < 4 + data[1] % 16 && at + 6 <= size; ++v) {
    Vec3 x;
    for (size_t d = 0; d < 3; ++d, at += 2)
      x[d] = std::floor((data[at] * 256 + data[at + 1]) / 65536.0 * 64 / step) * step;
    mesh.position_of.push_back(int32_t(mesh.position.size()));
    mesh.position.push_back(x);
  }
  const size_t count = mesh.position.size();
  for (; count > 0 && at + 3 <= size; at += 3)
    for (size_t c = 0; c < 3; ++c) group.corner.push_back(int32_t(data[at + c] % count));
  return asset;
}

Voxelized check_voxels(const Surface& surface, const VoxelizeOptions& options) {
  Voxelized v = voxelize(surface, options);
  require(v.grid.voxel_count() > 0, "a grid has voxels");
  for (int64_t i = 0; i < v.grid.voxel_count(); ++i) {
    require(v.grid.fill(i) > 0 && v.grid.fill(i) <= 1, "a fill lies in (0, 1]");
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
      require(v.grid.shape_mean(i, c) >= 0, "a mean is not negative");
      sum += v.grid.shape_mean(i, c);
    }
    require(std::abs(sum - 1) < 1e-9, "the means of a voxel sum to 1");
  }
  require(v.part.empty() == v.grid.part.empty(), "parts of triangles are parts of the grid");
  return v;
}

void check_embedding(const VoxelGrid& grid, const Surface& surface) {
  Body body;
  body.surface = surface;
  body.carried = surface.vertices;
  const Array<int32_t> part = parts_of_carried(body);
  const Embedding embedding = embed(grid, surface.vertices, part);
  for (int64_t p = 0; p < embedding.voxel.rows(); ++p) {
    require(embedding.voxel(p) >= 0 && embedding.voxel(p) < grid.voxel_count(),
            "a vertex lies in a voxel");
    require(part.empty() || grid.part(embedding.voxel(p)) == part(p), "of its part");
    double sum = 0;
    for (int c = 0; c < 8; ++c) sum += embedding.weights(p, c);
    require(std::abs(sum - 1) < 1e-9, "the weights of a vertex sum to 1");
  }
}

}  // namespace
}  // namespace elastogen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace elastogen;
  if (size < 2) return 0;
  try {
    Surface surface = pose_surface(asset_of(data, size));
    VoxelizeOptions options{.voxels = 12, .max_voxels = 20000};
    options.part_pieces = data[0] & 8;
    if (data[0] & 16)  // up to two voxels
      options.thickness = (1 + data[0] / 32) * surface.box.extent(0) / 48;
    const Voxelized v = check_voxels(surface, options);
    surface.part = v.part;
    check_embedding(v.grid, surface);
  } catch (const Error& error) {
    const bool expected =
        error.kind() == ErrorKind::kAsset || error.kind() == ErrorKind::kResources;
    require(expected, concat("an error of the wrong kind: ", error.what()));
  }
  return 0;
}
