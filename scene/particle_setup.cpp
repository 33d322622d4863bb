// SPDX-License-Identifier: Apache-2.0
#include "scene/particle_setup.hpp"

#include "core/error.hpp"
#include "mpm_fem/mpm/fill.hpp"

namespace elastogen {
namespace {

void refuse(bool asked, const char* option) {
  ELASTOGEN_CHECK(!asked, option,
                  ": not for particles yet; --method fem steps the body on voxel hexahedra");
}

}  // namespace

void add_particles(const RunDescription& run, Setup& setup) {
  refuse(!run.pins.empty(), "--pin");
  refuse(!run.holds.empty(), "--hold");
  refuse(!run.moves.empty(), "--move");
  refuse(!run.tractions.empty(), "--traction");
  refuse(!run.state.empty(), "--state");
  refuse(run.fem && run.fem->statics, "statics");
  const VoxelGrid& grid = setup.scene.grid;
  std::vector<Solid> solids;
  for (size_t k = 0; k < setup.scene.materials.size(); ++k)
    solids.push_back({setup.scene.materials[k], setup.yields[k]});
  ParticleSetup particles{mpm::fill_body(grid, setup.scene.material, solids), {}};
  const Array<double>& x = particles.particles.x;
  particles.nodes.h = grid.h;
  particles.nodes.origin = grid.origin;
  particles.nodes.rest = x;
  setup.node_of = Array<int32_t>(x.rows());
  for (int64_t k = 0; k < x.rows(); ++k) {
    setup.node_of(k) = int32_t(k);
    for (int a = 0; a < 3; ++a) particles.nodes.rest(k, a) += grid.origin[size_t(a)];
  }
  setup.body.carried = particles.nodes.rest;
  setup.particles = std::move(particles);
}

Asset shown_asset(const Asset& asset, const Setup& setup) {
  if (!setup.particles) return asset;
  Asset cloud;
  cloud.path = asset.path;
  cloud.format = "particles";
  cloud.up = asset.up;
  cloud.unit = asset.unit;
  PointCloud& points = cloud.points.emplace();
  const Array<double>& x = setup.particles->nodes.rest;
  const double scale = setup.body.surface.scale;
  for (int64_t k = 0; k < x.rows(); ++k)
    points.position.push_back({(x(k, 0) + setup.scene.place[0]) / scale,
                               (x(k, 1) + setup.scene.place[1]) / scale,
                               (x(k, 2) + setup.scene.place[2]) / scale});
  return cloud;
}

}  // namespace elastogen
