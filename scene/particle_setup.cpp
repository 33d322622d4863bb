// SPDX-License-Identifier: Apache-2.0
#include "scene/particle_setup.hpp"

#include "core/error.hpp"
#include "core/mat3.hpp"
#include "core/vec3.hpp"
#include "io/safe_file.hpp"
#include "mpm_fem/mpm/fill.hpp"
#include "voxelize/labels.hpp"

namespace elastogen {
namespace {

void refuse(bool asked, const char* option) {
  ELASTOGEN_CHECK(!asked, option,
                  ": not for particles yet; --method fem steps the body on voxel hexahedra");
}

using Colour = std::array<float, 4>;

/// Colours of a surface's triangles; empty where the asset has none.
std::vector<Colour> triangle_colours(const Asset& asset, const Surface& surface) {
  std::vector<Colour> colours(size_t(surface.triangles.rows()), Colour{1, 1, 1, 1});
  bool coloured = false;
  for (const SurfaceInstance& instance : surface.instances) {
    const Mesh& mesh = asset.meshes[size_t(instance.mesh)];
    for (int64_t k = 0; k < instance.triangles; ++k) {
      const int64_t t = instance.first_triangle + k;
      Colour& colour = colours[size_t(t)];
      if (const int32_t m = surface.material(t); m >= 0)
        colour = asset.materials[size_t(m)].base_colour, coloured = true;
      if (mesh.colour.empty()) continue;
      coloured = true;
      for (size_t c = 0; c < 4; ++c) {
        float mean = 0;
        for (int corner = 0; corner < 3; ++corner)
          mean += mesh.colour[size_t(surface.triangles(t, corner) - instance.first_vertex)][c] / 3;
        colour[c] *= mean;
      }
    }
  }
  if (!coloured) colours.clear();
  return colours;
}

ParticleSetup filled(const RunDescription& run, const Setup& setup) {
  const VoxelGrid& grid = setup.scene.grid;
  const mpm::FillOptions options{.per_edge = run.particles.per_edge,
                                 .jitter = run.particles.jitter};
  std::vector<Solid> solids;
  for (size_t k = 0; k < setup.scene.materials.size(); ++k)
    solids.push_back({setup.scene.materials[k], setup.yields[k]});
  if (run.shape && run.shape->in_plane()) {
    const PlacedBox& box = setup.body.surface.box;
    const auto inside = [&](const Vec3& x) { return run.shape->contains(plus(x, box.origin)); };
    return {mpm::fill_plane(box.lower, box.upper, grid.h, solids[0], inside, options), {}, {}, 2};
  }
  mpm::Filled body = mpm::fill_body(grid, setup.scene.material, solids, options);
  return {std::move(body.particles), {}, std::move(body.voxel)};
}

}  // namespace

void add_particles(const RunDescription& run, Setup& setup) {
  refuse(!run.pins.empty(), "--pin");
  refuse(!run.holds.empty(), "--hold");
  refuse(!run.moves.empty(), "--move");
  refuse(!run.tractions.empty(), "--traction");
  refuse(!run.state.empty(), "--state");
  refuse(run.fem && run.fem->statics, "statics");
  for (const std::string& path : run.outputs)
    ELASTOGEN_CHECK(ending_of(path) != "pvd", path,
                    ": particles are written as points, .ply (one file a frame) or .pc2");
  const VoxelGrid& grid = setup.scene.grid;
  ParticleSetup particles = filled(run, setup);
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

State particle_start(const Setup& setup, const StartMotion& motion) {
  Scene nodes;  // only what initial_state looks at
  nodes.grid = setup.particles->nodes;
  nodes.mass = setup.particles->particles.mass;
  nodes.pinned = Array<uint8_t>(nodes.grid.node_count());
  return initial_state(nodes, motion);
}

CloudReport cloud_of(const mpm::Particles& p, const Vec3& origin) {
  CloudReport cloud;
  for (int64_t k = 0; k < p.count(); ++k) {
    cloud.volume += determinant(load_matrix(p.F.row(k))) * p.volume(k);
    for (size_t a = 0; a < 3; ++a) {
      const double x = p.x(k, int(a)) + origin[a];
      cloud.lower[a] = std::min(cloud.lower[a], x);
      cloud.upper[a] = std::max(cloud.upper[a], x);
    }
  }
  return cloud;
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
  if (!setup.body.is_asset) return cloud;
  const std::vector<Colour> colours = triangle_colours(asset, setup.body.surface);
  if (colours.empty()) return cloud;
  const Array<int32_t> triangle = nearest_triangles(setup.scene.grid, setup.body.surface);
  for (int64_t k = 0; k < x.rows(); ++k)
    points.colour.push_back(colours[size_t(triangle(setup.particles->voxel(k)))]);
  return cloud;
}

}  // namespace elastogen
