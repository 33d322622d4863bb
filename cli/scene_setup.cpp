// SPDX-License-Identifier: Apache-2.0
#include "cli/scene_setup.hpp"

#include "cli/asset_stages.hpp"
#include "cli/boundary_option.hpp"
#include "cli/collider_option.hpp"
#include "cli/loose_pieces.hpp"
#include "cli/region_option.hpp"
#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/stopwatch.hpp"
#include "core/time_scheme.hpp"
#include "core/vec3.hpp"
#include "mpm_fem/fem/tet_surface.hpp"
#include "network/contact.hpp"
#include "voxelize/regions.hpp"
#include "voxelize/voxelize.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

/// The free side of a floor across the up axis is up, of another one the positive side; without a
/// place it lies where the asset begins.
Collider make_floor(const FloorOption& option, double friction, const UpAxis& up,
                    const PlacedBox& box) {
  const auto axis = size_t(option.axis < 0 ? up.axis : option.axis);
  const double sign = int(axis) == up.axis ? up.sign : 1;
  Vec3 normal = {};
  normal[axis] = sign;
  const double begin = sign > 0 ? box.lower[axis] : box.upper[axis];
  const double place = option.place ? *option.place - box.origin[axis] : begin;
  return half_space(normal, sign * place, friction);
}

/// The floor, then the colliders as they were named.
std::vector<Collider> make_colliders(const AnimateOptions& o, const UpAxis& up,
                                     const PlacedBox& box) {
  std::vector<Collider> colliders;
  if (o.floor) colliders.push_back(make_floor(*o.floor, o.friction, up, box));
  for (size_t k = 0; k < o.colliders.size(); ++k)
    colliders.push_back(
        parse_collider(o.colliders[k], box, fmt::format("collider {}", k + 1), o.friction));
  return colliders;
}

/// Planes of pins, holds, moves and colliders, so that a layer of nodes lies in them.
VoxelizeOptions voxelize_options(const AnimateOptions& o, const std::vector<Collider>& colliders,
                                 const PlacedBox& box) {
  VoxelizeOptions v = resolution(o);
  std::vector<Selection> selections;
  for (const std::string& pin : o.pins) selections.push_back(parse_selection(pin));
  for (const std::string& hold : o.holds) selections.push_back(parse_hold(hold).selection);
  for (const std::string& move : o.moves) selections.push_back(parse_move(move).selection);
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

/// Says so where a selection has no node.
void check_holds(const char* option, const std::string& text, const Array<uint8_t>& selected,
                 const PlacedBox& box, std::vector<std::string>& warnings) {
  const uint8_t* nodes = selected.data();
  if (std::any_of(nodes, nodes + selected.rows(), [](uint8_t s) { return s != 0; })) return;
  const Vec3 lower = plus(box.lower, box.origin), upper = plus(box.upper, box.origin);
  warnings.push_back(fmt::format(
      "{} '{}' holds nothing: no node of the grid lies in it; the asset spans {:.4g}..{:.4g}, "
      "{:.4g}..{:.4g}, {:.4g}..{:.4g} m",
      option, text, lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]));
}

void pin(const AnimateOptions& o, const PlacedBox& box, Scene& scene,
         std::vector<std::string>& warnings) {
  scene.pinned = Array<uint8_t>(scene.grid.node_count());
  for (const std::string& text : o.pins) {
    const Array<uint8_t> selected = select_nodes(scene.grid, parse_selection(text), box);
    for (int64_t n = 0; n < selected.rows(); ++n) scene.pinned(n) |= selected(n);
    check_holds("--pin", text, selected, box, warnings);
  }
  for (const std::string& text : o.holds)
    check_holds("--hold", text, select_nodes(scene.grid, parse_hold(text).selection, box), box,
                warnings);
  for (const std::string& text : o.moves)
    check_holds("--move", text, select_nodes(scene.grid, parse_move(text).selection, box), box,
                warnings);
}

/// A body that begins in a collider can never be stepped.
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

/// Steps a frame for which dt <= 1/60 s and the elastic Courant number stays at or below 50.
int automatic_substeps(const Scene& scene, double frame_seconds) {
  Scene probe;
  probe.materials = scene.materials;
  probe.grid.h = scene.grid.h;
  probe.dt = frame_seconds;
  const double wanted = std::max(60 * frame_seconds, courant_number(probe) / 50);
  return int(std::clamp(std::ceil(wanted - 1e-9), 1.0, 16.0));
}

/// Size, up and colliders of a setup that has its body; fills the asset's part of the report.
void add_asset(const Asset& asset, const AnimateOptions& o, Setup& setup, RunReport& report) {
  report.asset = summary_of(asset, setup.body, o);
  if (!report.asset.size.warning.empty()) report.warnings.push_back(report.asset.size.warning);
  setup.longest_edge = report.asset.size.longest_edge;
  setup.up = report.asset.up.up;
  setup.scene.place = setup.body.surface.box.origin;
  setup.scene.colliders = make_colliders(o, setup.up, setup.body.surface.box);
}

/// Body, grid and colliders; fills the asset's part of the report.
void add_grid(const Asset& asset, const AnimateOptions& o, Setup& setup, RunReport& report) {
  setup.body = make_body(asset, o.size, resolution(o));
  add_asset(asset, o, setup, report);
  const Surface& surface = setup.body.surface;
  VoxelizeOptions options = voxelize_options(o, setup.scene.colliders, surface.box);
  options.shell = setup.body.shell;
  Voxelized voxelized = voxelize(surface, options);
  take_findings(asset, voxelized, setup.body, report);
  setup.sheet_volume = voxelized.report.sheet_volume;
  setup.sheet_thickness = voxelized.report.sheet_thickness;
  if (setup.body.shell > 0 && o.thickness > setup.body.shell)
    report.warnings.push_back(fmt::format(
        "--thickness {:.4g} m: the shell around the points is {:.4g} m thick, and no thicker",
        o.thickness, setup.body.shell));
  setup.scene.grid = std::move(voxelized.grid);
}

/// The same of tetrahedra, which take the place of the grid.
void add_tets(const TetAsset& tets, const AnimateOptions& o, Setup& setup, RunReport& report) {
  setup.body.surface = pose_surface(tets.asset, o.size);
  setup.body.carried = setup.body.surface.vertices;
  add_asset(tets.asset, o, setup, report);
  report.asset.closed = true;
  if (o.fem->resolution)
    report.warnings.push_back(
        concat("--voxels and --h mean nothing: ", tets.asset.path, " has tetrahedra of its own"));
  setup.tets = tets.mesh;
  setup.tets->element = element_of(tets, *o.fem);
  for (int64_t n = 0; n < setup.tets->rest.rows(); ++n)
    for (int d = 0; d < 3; ++d) {
      double& x = setup.tets->rest(n, d);
      x = x * setup.body.surface.scale - setup.scene.place[size_t(d)];
    }
  setup.node_of = tets.node_of;
  setup.scene.grid.rest = setup.tets->rest;
  setup.scene.grid.h = fem::mean_edge(*setup.tets);
}

/// Gravity, time step and scheme.
void add_time(const AnimateOptions& o, Setup& setup) {
  Scene& scene = setup.scene;
  Vec3 down = {};
  down[size_t(setup.up.axis)] = -kReferenceGravity * setup.up.sign;
  scene.gravity = o.gravity.value_or(down);
  setup.substeps = o.substeps > 0 ? o.substeps : automatic_substeps(scene, 1 / o.fps);
  scene.dt = 1 / (o.fps * setup.substeps);
  scene.scheme = o.scheme;
  scene.hourglass = o.hourglass;
}

/// Nothing against gravity.
bool falls_freely(const AnimateOptions& o, const Scene& scene) {
  if (!o.holds.empty() || !o.moves.empty()) return false;
  const uint8_t* pinned = scene.pinned.data();
  const bool held = std::any_of(pinned, pinned + scene.pinned.rows(), [](uint8_t p) { return p; });
  return !held && scene.colliders.empty() && scene.gravity != Vec3{};
}

/// The vertices of a surface, each for a third of its triangles; nothing carries them yet.
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

/// What the report says of the scene, and a warning where nothing holds it.
void add_summary(const AnimateOptions& o, const Scene& scene, RunReport& report) {
  if (falls_freely(o, scene))
    report.warnings.push_back(
        "nothing holds the asset (no --pin, no --floor, no --collider): it falls freely");
  report.voxels = scene.grid.voxel_count();
  report.nodes = scene.grid.node_count();
  report.h = scene.grid.h;
  report.materials = scene.materials;
}

}  // namespace

Setup set_up(const Asset& asset, const AnimateOptions& o, const std::vector<Material>& materials,
             const std::function<Array<int32_t>(const VoxelGrid&)>& regions, RunReport& report) {
  Setup setup;
  Scene& scene = setup.scene;
  const Stopwatch watch;
  add_grid(asset, o, setup, report);
  report.stage_seconds.voxelize = watch.seconds();

  scene.materials = materials.empty() ? std::vector<Material>{o.material} : materials;
  scene.material = regions ? regions(scene.grid) : Array<int32_t>(scene.grid.voxel_count());
  apply_regions(o.regions, asset, setup.body, scene, report.warnings);
  pin(o, setup.body.surface.box, scene, report.warnings);
  if (!scene.colliders.empty()) scene.surface = surface_points(scene.grid, setup.body.surface);
  for (const Collider& collider : scene.colliders) check_clear(scene, collider);
  add_time(o, setup);
  judge_pieces(asset, setup, o, report);
  finish_scene(scene);
  add_summary(o, scene, report);
  report.stage_seconds.setup = watch.seconds() - report.stage_seconds.voxelize;
  return setup;
}

Setup set_up(const TetAsset& tets, const AnimateOptions& o, RunReport& report) {
  Setup setup;
  Scene& scene = setup.scene;
  const Stopwatch watch;
  add_tets(tets, o, setup, report);
  scene.materials = {o.material};
  scene.material = Array<int32_t>(setup.tets->elements.rows());
  apply_regions(o.regions, *setup.tets, tets.region, tets.regions, setup.body.surface.box, scene,
                report.warnings);
  setup.tets->material = scene.material;
  pin(o, setup.body.surface.box, scene, report.warnings);
  scene.surface = vertex_points(setup.body.surface);
  for (const Collider& collider : scene.colliders) check_clear(scene, collider);
  add_time(o, setup);
  add_summary(o, scene, report);
  report.stage_seconds.setup = watch.seconds();
  return setup;
}

void print_setup(const Setup& setup, const AssetSummary& asset, const AnimateOptions& o) {
  const Scene& scene = setup.scene;
  fmt::print("longest edge {:.4g} m ({}), {} up ({})\n", asset.size.longest_edge,
             asset.size.from.reason, up_name(asset.up.up), asset.up.from.reason);
  if (setup.tets)
    fmt::print("{} tetrahedra ({}) of {:.4g} m, {} nodes\n", setup.tets->elements.rows(),
               fem::element_name(setup.tets->element), scene.grid.h, scene.grid.node_count());
  else
    fmt::print("{} voxels of {:.4g} m, {} nodes, {} piece{}\n", scene.grid.voxel_count(),
               scene.grid.h, scene.grid.node_count(), scene.grid.pieces,
               scene.grid.pieces == 1 ? "" : "s");
  for (const Material& m : scene.materials)
    fmt::print("{}: {}, E {:.4g} Pa, nu {:.4g}, rho {:.4g} kg/m^3\n", m.name, law_name(m.law),
               m.young, m.poisson, m.density);
  if (setup.sheet_volume > 0)
    fmt::print("{} of {:.4g} m ({}), {:.4g} kg\n", setup.body.shell > 0 ? "shell" : "sheets",
               setup.sheet_thickness,
               setup.sheet_thickness == o.thickness ? "--thickness"
               : setup.body.shell > 0               ? "by its points; --thickness sets it"
                                                    : "a voxel; --thickness sets it",
               scene.materials[0].density * setup.sheet_volume);
  if (o.fem && o.fem->statics) {
    fmt::print("static equilibrium\n");
    std::fflush(stdout);
    return;
  }
  fmt::print("{} frames at {:.4g} fps, {} step{} a frame of {:.4g} s, Courant number {:.3g}\n",
             o.frames, o.fps, setup.substeps, setup.substeps == 1 ? "" : "s", scene.dt,
             courant_number(scene));
  fmt::print("numerical damping: a vibration of 1 / 5 / 20 Hz keeps");
  for (const double f : {1.0, 5.0, 20.0})
    fmt::print("{} {:.0f} %", f == 1 ? "" : " /",
               100 * amplitude_kept(scene.scheme, 2 * std::numbers::pi * f * scene.dt));
  fmt::print(" of its amplitude a period\n");
  std::fflush(stdout);
}

}  // namespace elastogen
