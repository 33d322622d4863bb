// SPDX-License-Identifier: Apache-2.0
#include "bench/lattice.hpp"

#include "core/error.hpp"
#include "voxelize/bricks.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace elastogen::bench {
namespace {

/// Thickness and distance of struts in voxels.
struct Struts {
  int width = 1, period = 1;
  double fill() const {
    const double r = double(width) / period;
    return r * r * (3 - 2 * r);
  }
  bool in(int x) const { return x % period < width; }
};

Struts struts_of(double fill) {
  Struts best{2, 2};
  for (const int width : {2, 3, 4})
    for (int period = width; period <= 20 * width; ++period) {
      const Struts s{width, period};
      if (std::abs(s.fill() - fill) < std::abs(best.fill() - fill)) best = s;
    }
  return best;
}

}  // namespace

Scene lattice(const SceneOptions& options, double fill) {
  ELASTOGEN_CHECK(fill >= 0.01 && fill <= 1, "the fill must lie in 0.01 ... 1, got ", fill);
  if (fill == 1) return cantilever(options);
  const Struts struts = struts_of(fill);
  // a box of 4n x n x n voxels; a voxel is in a strut where two coordinates are within its width
  const int n = std::max(1, int(std::lround(std::cbrt(options.voxels / (4 * struts.fill())))));
  std::vector<int32_t> coords;
  for (int z = 0; z < n; ++z)
    for (int y = 0; y < n; ++y)
      for (int x = 0; x < 4 * n; ++x)
        if (struts.in(x) + struts.in(y) + struts.in(z) >= 2) coords.insert(coords.end(), {x, y, z});
  Array<int32_t> voxels(int64_t(coords.size()) / 3, 3);
  std::copy(coords.begin(), coords.end(), voxels.data());

  // a small cantilever with its grid replaced
  SceneOptions smallest = options;
  smallest.voxels = 4;
  Scene scene = cantilever(smallest);
  const double h = 1.0 / (4 * n), ratio = h / scene.grid.h;
  scene.materials[0].young *= ratio * ratio;  // the Courant number stays
  scene.grid = make_grid(voxels, h, {});
  scene.material = Array<int32_t>(scene.grid.voxel_count());
  scene.pinned = Array<uint8_t>(scene.grid.node_count());
  for (int64_t k = 0; k < scene.grid.node_count(); ++k)
    scene.pinned(k) = scene.grid.node_coord(k, 0) == 0;
  finish_scene(scene);
  return scene;
}

Scene step_scene(const std::string& name, const SceneOptions& options, double fill) {
  if (name == "beam") return lattice(options, fill);
  if (name == "ball") return porous_ball(options);
  ELASTOGEN_CHECK(name == "c84", "unknown scene '", name, "'; known are beam, ball, c84");
  Scene scene = cantilever(options);
  scene.dt = 1.0 / 30;
  scene.materials[0].young = 1e5;
  finish_scene(scene);
  return scene;
}

}  // namespace elastogen::bench
