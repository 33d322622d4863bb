// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "io/read_asset.hpp"
#include "tests/voxelize/shapes.hpp"
#include "tests/voxelize/sliver_rules.hpp"
#include "voxelize/embedding.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <set>

namespace elastogen {
namespace {

using namespace test;
namespace fs = std::filesystem;

constexpr double kSpotVolume = 0.7183;

/// The folder of ELASTOGEN_ASSETS; empty, with a printed line, where it is not set.
fs::path assets() {
  const char* folder = std::getenv("ELASTOGEN_ASSETS");
  if (!folder) std::printf("ELASTOGEN_ASSETS is not set: skipped\n");
  return folder ? folder : "";
}

Surface read(const fs::path& path, double size = 0) {
  return pose_surface(read_asset(path.string()), size);
}

TEST(Assets, VariantsOfSpotHaveItsVolume) {
  const fs::path folder = assets();
  if (folder.empty()) return;
  const std::pair<const char*, double> variants[] = {
      {"closed/spot.obj", 1e-4},
      {"broken/spot_flipped.obj", 1e-4},
      {"broken/spot_mixed_winding.obj", 1e-4},
      {"broken/spot_duplicated_faces.obj", 1e-4},
      {"broken/spot_duplicated_vertices.obj", 1e-4},
      {"broken/spot_zero_area.obj", 1e-4},
      {"broken/spot_unreferenced.obj", 1e-4},
      {"broken/spot_far_1e7.obj", 1e-4},
      {"broken/spot_zup.stl", 1e-4},
      {"broken/spot_holes.obj", 0.01},
  };
  for (const auto& [name, tolerance] : variants)
    EXPECT_NEAR(voxelize(read(folder / name)).grid.volume / kSpotVolume, 1, tolerance) << name;
}

TEST(Assets, SizeDoesNotChangeTheVoxelsOfSpot) {
  const fs::path folder = assets();
  if (folder.empty()) return;
  const VoxelGrid spot = voxelize(read(folder / "closed/spot.obj")).grid;
  for (const char* name :
       {"broken/spot_micrometres.obj", "broken/spot_parsec.obj", "broken/spot_far_1e7.obj"})
    EXPECT_EQ(voxelize(read(folder / name)).grid.voxel_count(), spot.voxel_count()) << name;
}

TEST(Assets, EveryMeshVoxelisesAndHoldsItsVertices) {
  const fs::path folder = assets();
  if (folder.empty()) return;
  // all files that the readers accept
  std::set<fs::path> files;
  for (const auto& entry : fs::recursive_directory_iterator(folder))
    if (entry.is_regular_file()) files.insert(entry.path());
  for (const fs::path& file : files) {
    Surface surface;
    try {
      surface = read(file, 1);
    } catch (const Error&) {
      continue;  // of a format or kind that the readers refuse; their own tests say which
    }
    // voxels, with the time that they need
    const auto start = std::chrono::steady_clock::now();
    const Voxelized result = voxelize(surface);
    const std::chrono::duration<double> seconds = std::chrono::steady_clock::now() - start;
    std::printf("%-40s %7ld voxels %6.3f s%s\n", file.filename().c_str(),
                static_cast<long>(result.grid.voxel_count()), seconds.count(),
                result.report.winding_number ? ", winding number" : "");
    ASSERT_GT(result.grid.voxel_count(), 0) << file;
    expect_means(result.grid);
    // vertices lie in or near their voxels
    const Embedding embedding = embed(result.grid, surface.vertices);
    for (int64_t t = 0; t < surface.triangles.size(); ++t) {
      const int32_t v = surface.triangles.data()[t];
      double lowest = 0;
      for (int c = 0; c < 8; ++c) lowest = std::min(lowest, embedding.weights(v, c));
      ASSERT_GT(lowest, -1) << file << " vertex " << v;
    }
    // slivers by their rules
    const SliverCounts slivers = expect_sliver_rules(surface, {}, 1000);
    std::printf("%40s %7ld slivers dropped (%.2f %% of the voxels), %ld kept\n", "",
                static_cast<long>(slivers.dropped),
                100.0 * double(slivers.dropped) / double(slivers.voxels),
                static_cast<long>(slivers.kept));
  }
}

}  // namespace
}  // namespace elastogen
