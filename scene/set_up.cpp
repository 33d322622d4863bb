// SPDX-License-Identifier: Apache-2.0
#include "scene/set_up.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/stopwatch.hpp"
#include "core/time_scheme.hpp"
#include "core/vec3.hpp"
#include "io/output_findings.hpp"
#include "mpm_fem/fem/tet_surface.hpp"
#include "network/contact/contact.hpp"
#include "scene/asset_stages.hpp"
#include "scene/fem_boundary.hpp"
#include "scene/fem_scene.hpp"
#include "scene/holds.hpp"
#include "scene/impact_speed.hpp"
#include "scene/loads.hpp"
#include "scene/loose_pieces.hpp"
#include "scene/moved_points.hpp"
#include "scene/particle_setup.hpp"
#include "scene/pins.hpp"
#include "scene/tet_pins.hpp"
#include "voxelize/regions.hpp"
#include "voxelize/voxelize.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

constexpr double kDeep = 1e3;  // half of the edge of boxes across the plane [m]

/// The free side of a floor is up if the floor lies across the up axis, else the positive side.
/// Without a place the floor lies where the asset begins.
Collider make_floor(const FloorPlane& option, double friction, const UpAxis& up,
                    const PlacedBox& box) {
  const auto axis = size_t(option.axis < 0 ? up.axis : option.axis);
  const double sign = int(axis) == up.axis ? up.sign : 1;
  Vec3 normal = {};
  normal[axis] = sign;
  const double begin = sign > 0 ? box.lower[axis] : box.upper[axis];
  const double place = option.place ? *option.place - box.origin[axis] : begin;
  return half_space(normal, sign * place, friction);
}

/// Cuts a collider with the plane z = 0: the faces of boxes across z are moved far away.
void flatten(Collider& c) {
  const bool box = c.shape == Collider::Shape::kBox;
  ELASTOGEN_CHECK(
      c.normal[2] == 0 && (box || c.shape == Collider::Shape::kPlane || c.centre[2] == 0),
      "collider '", c.name, "': in the plane z = 0 planes stand upright on it and spheres ",
      "have their centre in it");
  if (box) c.centre[2] = 0, c.half[2] = kDeep;
  for (PathKey& key : c.path.keys) key.offset[2] = 0;
}

/// The floor, then the colliders in the order in which they were named.
std::vector<Collider> make_colliders(const RunDescription& run, const UpAxis& up,
                                     const PlacedBox& box) {
  std::vector<Collider> colliders;
  if (run.floor) colliders.push_back(make_floor(*run.floor, run.friction, up, box));
  for (size_t k = 0; k < run.colliders.size(); ++k)
    colliders.push_back(
        place_obstacle(run.colliders[k], box, fmt::format("collider {}", k + 1), run.friction));
  for (Collider& c : colliders) {
    ELASTOGEN_CHECK(c.friction != kSticks || method_of(run) == Method::kMpm, "collider '", c.name,
                    "': only particles stick; give a number as its friction");
    if (run.shape && run.shape->in_plane()) flatten(c);
  }
  return colliders;
}

/// Options whose grid has layers of nodes in the planes of pins, holds, moves and colliders.
VoxelizeOptions voxelize_options(const RunDescription& run, const std::vector<Collider>& colliders,
                                 const PlacedBox& box) {
  VoxelizeOptions v = resolution(run);
  add_borders(run, box, v);
  std::vector<Selection> selections;
  if (v.borders.empty())
    for (const Pin& pin : run.pins) selections.push_back(pin.selection);
  for (const Hold& hold : run.holds) selections.push_back(hold.selection);
  for (const Move& move : run.moves) selections.push_back(move.selection);
  for (const Selection& selection : selections) {
    const auto at = plane(selection, box);
    if (at && !v.align[at->first]) v.align[at->first] = at->second;
  }
  for (const Collider& c : colliders)
    for (size_t d = 0; d < 3; ++d)
      if (c.shape == Collider::Shape::kPlane && std::abs(c.normal[d]) == 1 && !v.align[d])
        v.align[d] = c.centre[d] + offset_at(c, 0)[d];
  return v;
}

/// Refuses a body that begins inside a collider, because it can never be stepped.
void check_clear(const Scene& scene, const Collider& collider) {
  const double layer = contact_layer(scene), h = scene.grid.h;
  const Collider core = core_of(collider, layer);
  Proximity deepest{.distance = 1e300};
  for (int64_t p = 0; p < scene.surface.position.rows(); ++p) {
    const double* x = scene.surface.position.row(p);
    const Proximity near = proximity(core, offset_at(collider, 0), {x[0], x[1], x[2]});
    if (near.distance < deepest.distance) deepest = near;
  }
  const double depth = layer - deepest.distance;
  const Vec3& n = deepest.normal;
  if (depth < 0.2 * h) return;
  const bool plane = collider.shape == Collider::Shape::kPlane;
  throw Error(fmt::format(
      "the asset begins {:.4g} m {} collider '{}'; move the collider by that along ({:.3g}, "
      "{:.3g}, {:.3g}), or further{}",
      depth, plane ? "below" : "inside of", collider.name, -n[0], -n[1], -n[2],
      collider.name == "floor" ? " (--floor alone takes the lowest point)" : ""));
}

/// Number of steps a frame with dt <= 1/60 s and an elastic Courant number of at most 50. Bodies
/// that yield, which the network does not step, need dt <= 1/240 s only. Particles with a dt of
/// their own use it, unless their steps are explicit.
int automatic_substeps(const RunDescription& run, const Setup& setup) {
  const Scene& scene = setup.scene;
  const double frame_seconds = 1 / run.fps;
  const bool transfers = method_of(run) == Method::kMpm && run.particles.dt > 0;
  if (transfers && run.particles.integrator != Integrator::kExplicit)
    return int(std::clamp(std::ceil(frame_seconds / run.particles.dt - 1e-9), 1.0, 1e4));
  if (!setup.yields.empty())
    return int(std::clamp(std::ceil(240 * frame_seconds - 1e-9), 1.0, 16.0));
  Scene probe;
  probe.materials = scene.materials;
  probe.grid.h = scene.grid.h;
  probe.dt = frame_seconds;
  const double wanted = std::max(60 * frame_seconds, courant_number(probe) / 50);
  return int(std::clamp(std::ceil(wanted - 1e-9), 1.0, 16.0));
}

/// Adds size, up and colliders to a setup that has its body.
void add_asset(const Asset& asset, const RunDescription& run, Setup& setup) {
  setup.asset = summary_of(asset, setup.body, run);
  if (!setup.asset.size.warning.empty()) setup.warnings.push_back(setup.asset.size.warning);
  setup.longest_edge = setup.asset.size.longest_edge;
  setup.up = setup.asset.up.up;
  setup.scene.place = setup.body.surface.box.origin;
  setup.scene.colliders = make_colliders(run, setup.up, setup.body.surface.box);
}

/// Adds body, grid, colliders and what the pins hold.
void add_grid(const Asset& asset, const RunDescription& run, Setup& setup) {
  setup.body = make_body(asset, run.size, resolution(run));
  add_asset(asset, run, setup);
  const Surface& surface = setup.body.surface;
  VoxelizeOptions options = voxelize_options(run, setup.scene.colliders, surface.box);
  options.shell = setup.body.shell;
  Voxelized voxelized = voxelize(surface, options);
  take_findings(asset, voxelized, setup.body, setup.asset);
  setup.sheet_volume = voxelized.report.sheet_volume;
  setup.sheet_thickness = voxelized.report.sheet_thickness;
  if (setup.body.shell > 0 && run.thickness > setup.body.shell)
    setup.warnings.push_back(fmt::format(
        "--thickness {:.4g} m: the shell around the points is {:.4g} m thick, and no thicker",
        run.thickness, setup.body.shell));
  setup.scene.grid = std::move(voxelized.grid);
  setup.parts = asset_parts(run, asset, setup.body, setup.scene.grid);
  pin(run, options.borders, voxelized.cut, setup);
  fix_axes(run, setup);
}

/// Adds body and colliders for tetrahedra, which replace the grid.
void add_tets(const TetAsset& tets, const RunDescription& run, Setup& setup) {
  setup.body.surface = pose_surface(tets.asset, run.size);
  setup.body.carried = setup.body.surface.vertices;
  add_asset(tets.asset, run, setup);
  setup.asset.closed = true;
  if (run.fem->resolution)
    setup.warnings.push_back(
        concat("--voxels and --h mean nothing: ", tets.asset.path, " has tetrahedra of its own"));
  setup.tets = tets.mesh;
  setup.tets->element = element_of(tets, *run.fem);
  for (int64_t n = 0; n < setup.tets->rest.rows(); ++n)
    for (int d = 0; d < 3; ++d) {
      double& x = setup.tets->rest(n, d);
      x = x * setup.body.surface.scale - setup.scene.place[size_t(d)];
    }
  setup.node_of = tets.node_of;
  setup.scene.grid.rest = setup.tets->rest;
  setup.scene.grid.h = fem::mean_edge(*setup.tets);
}

/// Sets gravity, time step and scheme.
void add_time(const RunDescription& run, Setup& setup) {
  Scene& scene = setup.scene;
  Vec3 down = {};
  down[size_t(setup.up.axis)] = -kReferenceGravity * setup.up.sign;
  scene.gravity = run.gravity.value_or(down);
  const bool is_auto = run.scheme == TimeScheme::kAuto;  // its steps are within one of a frame
  setup.substeps = run.substeps > 0 ? run.substeps : is_auto ? 1 : automatic_substeps(run, setup);
  scene.dt = 1 / (run.fps * setup.substeps);
  scene.scheme = run.scheme;
  scene.hourglass = run.hourglass;
}

/// Whether nothing resists gravity.
bool falls_freely(const RunDescription& run, const Scene& scene) {
  if (!run.holds.empty() || !run.moves.empty()) return false;
  const uint8_t* pinned = scene.pinned.data();
  const bool held = std::any_of(pinned, pinned + scene.pinned.rows(), [](uint8_t p) { return p; });
  return !held && scene.colliders.empty() && scene.gravity != Vec3{};
}

/// The nodes of plane triangles, each with its share of their rim; inner nodes have none.
SurfacePoints rim_points(const fem::ElementMesh& mesh, const Array<int32_t>& node_of) {
  const Array<double> area = fem::rim_area(mesh);
  SurfacePoints points;
  points.position = Array<double>(node_of.rows(), 3);
  points.area = Array<double>(node_of.rows());
  for (int64_t p = 0; p < node_of.rows(); ++p) {
    std::copy_n(mesh.rest.row(node_of(p)), 3, points.position.row(p));
    points.area(p) = area(node_of(p));
  }
  return points;
}

/// The vertices of a surface, each with a third of the area of its triangles; not carried yet.
SurfacePoints vertex_points(const Surface& surface) {
  SurfacePoints points;
  points.position = surface.vertices;
  points.area = Array<double>(surface.vertices.rows());
  for (int64_t t = 0; t < surface.triangles.rows(); ++t) {
    Vec3 x[3];
    for (int c = 0; c < 3; ++c)
      std::copy_n(surface.vertices.row(surface.triangles(t, c)), 3, x[c].begin());
    const double area = norm(cross(minus(x[1], x[0]), minus(x[2], x[0]))) / 2;
    for (int c = 0; c < 3; ++c) points.area(surface.triangles(t, c)) += area / 3;
  }
  return points;
}

/// Empties the list of yields if no material yields.
void drop_elastic(std::vector<Yield>& yields) {
  const auto is_elastic = [](const Yield& yield) { return yield.index() == 0; };
  if (std::all_of(yields.begin(), yields.end(), is_elastic)) yields.clear();
}

/// Warns if nothing holds the scene; adds findings about what the outputs cannot hold.
void judge(const Asset& asset, const RunDescription& run, Setup& setup) {
  if (falls_freely(run, setup.scene))
    setup.warnings.push_back(
        "nothing holds the asset (no --pin, no --floor, no --collider): it falls freely");
  if (run.fem && run.fem->statics)
    for (std::string& text : unheld_pieces(fem_scene(setup, run)))
      setup.warnings.push_back(std::move(text));
  const Asset& shown = shown_asset(asset, setup);
  for (Finding& finding : output_findings(shown, setup.body.surface, run.outputs))
    setup.asset.findings.push_back(std::move(finding));
}

/// A shape in the plane. It has particles and no voxels.
Setup set_up_plane(const Asset& asset, const RunDescription& run) {
  // only particles of one material
  ELASTOGEN_CHECK(
      method_of(run) == Method::kMpm, "--shape ", asset.path,
      ": in the plane only particles are stepped, of a material that yields: sand, snow, ",
      "or another one with --method mpm");
  ELASTOGEN_CHECK(run.regions.empty(), "--region: in the plane a shape is of one material");
  // body, time step and loads, all in the plane
  Setup setup;
  Scene& scene = setup.scene;
  const Stopwatch watch;
  setup.body.surface = pose_surface(asset);
  add_asset(asset, run, setup);
  scene.grid.h = run.h > 0 ? run.h : setup.longest_edge / run.voxels;
  scene.materials = {run.material};
  setup.yields = {run.yield};
  add_time(run, setup);
  ELASTOGEN_CHECK(scene.gravity[2] == 0 && run.motion.velocity[2] == 0 && run.motion.spin[0] == 0 &&
                      run.motion.spin[1] == 0,
                  "--gravity, --velocity, --spin: nothing moves across the plane z = 0");
  // particles, which must not begin inside a collider
  judge(asset, run, setup);
  add_particles(asset, run, setup);
  scene.surface.position = setup.particles->particles.x;
  for (const Collider& collider : scene.colliders) check_clear(scene, collider);
  setup.other_seconds = watch.seconds();
  return setup;
}

/// Gives the materials the damping of their presets where the scene chooses none: euler and bdf2
/// damp more than that by themselves.
void damp(const RunDescription& run, Setup& setup) {
  const bool by_fem = run.fem && !run.fem->statics && !run.fem->newmark;
  const bool may = (by_fem || !run.fem) && method_of(run) != Method::kMpm && setup.yields.empty();
  bool damped = false;
  for (Material& m : setup.scene.materials) {
    if (!m.loss_factor && may && has_stages(run.scheme)) m.loss_factor = m.usual_loss;
    damped |= m.loss_factor.value_or(0) > 0;
  }
  if (!damped) return;
  ELASTOGEN_CHECK(may && (run.fem || run.solver.mode != SolverMode::kPaper),
                  "--damping: particles, materials that yield, statics, Newmark's scheme and the ",
                  "solver 'paper' have none");
}

}  // namespace

Setup set_up(const Asset& asset, const RunDescription& run) {
  if (run.shape && run.shape->in_plane()) return set_up_plane(asset, run);
  // body and voxels
  Setup setup;
  Scene& scene = setup.scene;
  const Stopwatch watch;
  add_grid(asset, run, setup);
  setup.voxelize_seconds = watch.seconds();

  // materials
  scene.materials = run.materials.empty() ? std::vector<Material>{run.material} : run.materials;
  scene.material =
      run.material_of ? run.material_of(scene.grid) : Array<int32_t>(scene.grid.voxel_count());
  setup.yields.assign(scene.materials.size(), run.materials.empty() ? run.yield : Yield{});
  apply_regions(run.regions, setup.parts, setup.body.surface.box, scene, setup.yields,
                setup.warnings);
  drop_elastic(setup.yields);
  damp(run, setup);
  // contact and time step
  if (!scene.colliders.empty()) {
    scene.surface = surface_points(scene.grid, setup.body.surface);
    drop_moved(rest_behind(setup.borders, setup.body.surface.box, scene.surface.position,
                           scene.surface.weights),
               setup);
  }
  for (const Collider& collider : scene.colliders) check_clear(scene, collider);
  add_time(run, setup);
  scene.impact_speed = impact_speed(scene, run.motion);
  judge_pieces(asset, run, setup);
  finish_scene(scene);
  if (!run.fem) add_forces(run, setup);
  add_wind(run, setup);
  // particles in place of voxels, if the body falls apart into grains
  if (method_of(run) == Method::kMpm) add_particles(asset, run, setup);
  hold_tets(run, setup);
  judge(asset, run, setup);
  setup.other_seconds = watch.seconds() - setup.voxelize_seconds;
  return setup;
}

Setup set_up(const TetAsset& tets, const RunDescription& run) {
  ELASTOGEN_CHECK(run.wind.keys.empty(), "--wind '", run.wind_text, "': tetrahedra of a file (",
                  tets.asset.path, ") feel none");
  Setup setup;
  Scene& scene = setup.scene;
  const Stopwatch watch;
  // elements, their materials, what holds them, contact and time step
  add_tets(tets, run, setup);
  scene.materials = {run.material}, setup.yields = {run.yield};
  scene.material = Array<int32_t>(setup.tets->elements.rows());
  setup.parts = asset_parts(run, tets);
  apply_regions(run.regions, setup.parts, *setup.tets, setup.body.surface.box, scene, setup.yields,
                setup.warnings);
  drop_elastic(setup.yields);
  setup.tets->material = scene.material;
  pin(run, {}, {}, setup);
  fix_axes(run, setup);
  scene.surface = fem::is_plane(setup.tets->element) ? rim_points(*setup.tets, setup.node_of)
                                                     : vertex_points(setup.body.surface);
  for (const Collider& collider : scene.colliders) check_clear(scene, collider);
  add_time(run, setup);
  scene.impact_speed = impact_speed(scene, run.motion);
  hold_tets(run, setup);
  judge(tets.asset, run, setup);
  setup.other_seconds = watch.seconds();
  return setup;
}

void add_summary(const Setup& setup, RunReport& report) {
  report.asset = setup.asset;
  report.voxels = setup.scene.grid.voxel_count();
  report.nodes = setup.scene.grid.node_count();
  report.h = setup.scene.grid.h;
  report.materials = setup.scene.materials;
  for (const Holder& holder : setup.scene.holders) report.holders.push_back(holder.name);
  report.warnings = setup.warnings;
  report.stage_seconds.voxelize = setup.voxelize_seconds;
  report.stage_seconds.setup = setup.other_seconds;
}

}  // namespace elastogen
