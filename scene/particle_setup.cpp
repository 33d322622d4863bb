// SPDX-License-Identifier: Apache-2.0
#include "scene/particle_setup.hpp"

#include "core/error.hpp"
#include "core/mat3.hpp"
#include "core/vec3.hpp"
#include "io/safe_file.hpp"
#include "mpm_fem/mpm/fill.hpp"
#include "scene/particle_colours.hpp"
#include "scene/particle_surface_writer.hpp"

#include <filesystem>

namespace elastogen {
namespace {

void refuse(bool asked, const char* option) {
  ELASTOGEN_CHECK(!asked, option,
                  ": not for particles yet; --method fem steps the body on voxel hexahedra");
}

/// Checks that every output can show particles, by its ending.
void check_endings(const RunDescription& run) {
  for (const std::string& path : run.outputs) {
    const std::string name = std::filesystem::path(path).replace_extension().string();
    ELASTOGEN_CHECK(ending_of(path) != "glb", path,
                    ": a GLB moves the vertices of a mesh, and particles have none; write ", name,
                    ".ply (points, one file a frame), ", name, ".mesh.ply or ", name,
                    ".obj (their surface), ", name, ".vdb, ", name, ".pvd or ", name, ".pc2");
  }
}

/// Checks that no output is a surface or volume, which need a body in space.
void check_surfaces(const RunDescription& run) {
  for (const std::string& path : run.outputs)
    ELASTOGEN_CHECK(!shows_surface(path), path,
                    ": particles in the plane have no surface; write .ply (points), .pvd or .pc2");
}

/// The particles as a point cloud, in the numbers of the asset.
Asset shown_cloud(const Asset& asset, const Setup& setup, const ParticleSetup& particles) {
  Asset cloud;
  cloud.path = asset.path;
  cloud.format = "particles";
  cloud.up = asset.up;
  cloud.unit = asset.unit;
  PointCloud& points = cloud.points.emplace();
  const Array<double>& x = particles.nodes.rest;
  const double scale = setup.body.surface.scale;
  for (int64_t k = 0; k < x.rows(); ++k)
    points.position.push_back({(x(k, 0) + setup.scene.place[0]) / scale,
                               (x(k, 1) + setup.scene.place[1]) / scale,
                               (x(k, 2) + setup.scene.place[2]) / scale});
  return cloud;
}

/// Borders of the pins. @throws Error (usage) where a pin is not a place.
std::vector<Border> held_borders(const RunDescription& run, const Setup& setup) {
  const Vec3& origin = setup.scene.grid.origin;
  std::vector<Border> held;
  for (const Pin& pin : run.pins) {
    std::optional<Border> border = border_of(pin.selection, setup.body.surface.box);
    ELASTOGEN_CHECK(border, "--pin '", pin.text,
                    "': particles are held by place only, in a plane, a box or a ball");
    border->lower = minus(border->lower, origin), border->upper = minus(border->upper, origin);
    held.push_back(*border);
  }
  return held;
}

ParticleSetup filled(const RunDescription& run, const Setup& setup) {
  const VoxelGrid& grid = setup.scene.grid;
  const mpm::FillOptions options{.per_edge = run.particles.per_edge,
                                 .jitter = run.particles.jitter};
  std::vector<Solid> solids;
  for (size_t k = 0; k < setup.scene.materials.size(); ++k)
    solids.push_back({setup.scene.materials[k], setup.yields[k]});
  ParticleSetup particles;
  particles.spacing = grid.h / options.per_edge;
  if (run.shape && run.shape->in_plane()) {
    const PlacedBox& box = setup.body.surface.box;
    const auto inside = [&](const Vec3& x) { return run.shape->contains(plus(x, box.origin)); };
    particles.dimension = 2;
    particles.particles = mpm::fill_plane(box.lower, box.upper, grid.h, solids[0], inside, options);
    return particles;
  }
  mpm::Filled body = mpm::fill_body(grid, setup.scene.material, solids, options);
  particles.particles = std::move(body.particles);
  particles.voxel = std::move(body.voxel);
  return particles;
}

}  // namespace

void add_particles(const Asset& asset, const RunDescription& run, Setup& setup) {
  // what particles cannot do
  refuse(!run.holds.empty(), "--hold");
  refuse(!run.moves.empty(), "--move");
  refuse(!run.tractions.empty(), "--traction");
  refuse(!run.forces.empty(), "--force");
  refuse(!run.wind.keys.empty(), "--wind");
  refuse(run.fem && run.fem->statics, "statics");
  check_endings(run);
  // fill the voxels; positions count from the grid's origin
  const VoxelGrid& grid = setup.scene.grid;
  std::vector<Border> held = held_borders(run, setup);
  ParticleSetup particles = filled(run, setup);
  particles.held = std::move(held);
  if (particles.dimension == 2) check_surfaces(run);
  const Array<double>& x = particles.particles.x;
  particles.nodes.h = grid.h;
  particles.nodes.origin = grid.origin;
  particles.nodes.rest = x;
  // they replace the nodes that frames follow
  setup.node_of = Array<int32_t>(x.rows());
  for (int64_t k = 0; k < x.rows(); ++k) {
    setup.node_of(k) = int32_t(k);
    for (int a = 0; a < 3; ++a) particles.nodes.rest(k, a) += grid.origin[size_t(a)];
  }
  // outputs show them as a cloud with the asset's colours
  particles.shown = shown_cloud(asset, setup, particles);
  if (!run.shape)
    particles.shown.points->colour =
        particle_colours(asset, setup, particles, setup.body.carried, particles.notes);
  std::erase_if(setup.asset.findings, [](const Finding& f) { return f.what == "carried-columns"; });
  setup.body.carried = particles.nodes.rest;
  setup.particles = std::move(particles);
}

const Asset& shown_asset(const Asset& asset, const Setup& setup) {
  return setup.particles ? setup.particles->shown : asset;
}

ParticleSet particle_set(const ParticleSetup& of) {
  return {of.particles.mass, of.particles.volume, of.particles.solid};
}

State particle_start(const Setup& setup, const StartMotion& motion) {
  Scene nodes;  // only the members that initial_state reads
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

}  // namespace elastogen
