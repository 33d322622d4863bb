// SPDX-License-Identifier: Apache-2.0
#include "scene/fem_scene.hpp"

#include "core/error.hpp"
#include "mpm_fem/fem/elastic_body.hpp"
#include "mpm_fem/fem/point_location.hpp"
#include "mpm_fem/fem/voxel_tets.hpp"
#include "scene/fem_boundary.hpp"
#include "scene/fem_holders.hpp"
#include "scene/host_stepper.hpp"

#include <algorithm>
#include <limits>

namespace elastogen {
namespace {

bool is_tets(fem::Element element) {
  return fem::nodes_of(element) != 8;
}

fem::ElementMesh mesh_of(const Scene& scene, fem::Element element) {
  ELASTOGEN_CHECK(!fem::is_plane(element),
                  "--element tri3: it steps the triangles of a file (.msh, .vtk, .vtu)");
  if (!is_tets(element)) return fem::voxel_mesh(scene, element);
  fem::ElementMesh mesh = fem::voxel_tets(scene, fem::VoxelSplit::kSix);
  if (element != fem::Element::kTet4) mesh = fem::quadratic(mesh);
  mesh.element = element;
  return mesh;
}

/// Contact points: those of the voxels' surface, carried by the tetrahedra of their voxel, or the
/// nodes on the surface of tetrahedra.
fem::ContactPoints contact_of(const Setup& setup, const fem::ElementMesh& mesh) {
  const Scene& scene = setup.scene;
  if (setup.tets) return fem::node_contact(scene, mesh, setup.node_of);
  fem::ContactPoints points = fem::voxel_contact(scene);
  if (!is_tets(mesh.element)) return points;
  const int64_t per_voxel = mesh.elements.rows() / scene.grid.voxel_count();
  const int64_t count = points.position.rows();
  points.nodes = Array<int32_t>(count, mesh.elements.cols());
  points.weights = Array<double>(count, mesh.elements.cols());
  for (int64_t p = 0; p < count; ++p) {
    const int64_t first = per_voxel * scene.surface.voxel(p);
    const int64_t e =
        fem::locate(mesh, first, first + per_voxel, points.position.row(p), points.weights.row(p));
    std::copy_n(mesh.elements.row(e), mesh.elements.cols(), points.nodes.row(p));
  }
  return points;
}

/// Materials with densities scaled so that the fills of the voxels have the mass of the scene,
/// which is the mass of the asset's volume.
std::vector<Material> materials_of(const Scene& scene) {
  const double h3 = scene.grid.h * scene.grid.h * scene.grid.h;
  double mass = 0, filled = 0;
  for (int64_t n = 0; n < scene.mass.rows(); ++n) mass += scene.mass(n);
  for (int64_t v = 0; v < scene.grid.voxel_count(); ++v)
    filled += scene.materials[size_t(scene.material(v))].density * scene.grid.fill(v) * h3;
  std::vector<Material> materials = scene.materials;
  for (Material& m : materials) m.density *= mass / filled;
  return materials;
}

/// The element for voxels whose material yields, as the voxel element cannot yield. With mean
/// dilatation only hardening resists the flattening of a point at a contact; without it: kHex.
fem::Element yielding_element(const std::vector<Yield>& yields) {
  for (const Yield& yield : yields) {
    const auto* metal = std::get_if<MetalYield>(&yield);
    const bool hardens = metal && metal->hardening > 0;
    if (yield.index() != 0 && !hardens) return fem::Element::kHex;
  }
  return fem::Element::kHexBbar;
}

fem::Scheme scheme_of(const Scene& scene, const FemOptions& options) {
  if (options.newmark) return fem::Scheme::kNewmark;
  switch (scene.scheme) {
    case TimeScheme::kBdf2:
      return fem::Scheme::kBdf2;
    case TimeScheme::kSdirk2:
      return fem::Scheme::kSdirk2;
    case TimeScheme::kAuto:
      return fem::Scheme::kAuto;
    default:
      return fem::Scheme::kEuler;
  }
}

}  // namespace

fem::ElementMesh whole_mesh(const Setup& setup, const RunDescription& run) {
  if (setup.tets) return *setup.tets;
  const bool yields = !run.fem->named && !setup.yields.empty();
  return mesh_of(setup.scene, yields ? yielding_element(setup.yields) : run.fem->element);
}

fem::FemScene fem_scene(const Setup& setup, const RunDescription& run) {
  const Scene& scene = setup.scene;
  const FemOptions& fem = *run.fem;
  fem::FemScene result;
  const fem::ElementMesh whole = whole_mesh(setup, run);
  result.mesh = setup.cut_mesh ? setup.cut_mesh->mesh : whole;
  result.yields = setup.yields;
  result.materials = setup.tets ? scene.materials : materials_of(scene);
  result.gravity = scene.gravity;
  add_boundary(setup, run, whole, result);
  result.dt = scene.dt;
  result.scheme = scheme_of(scene, fem);
  result.mass_kind = fem.mass;
  const bool lumped = fem.mass == fem::Mass::kLumped;
  if (lumped && !is_tets(result.mesh.element)) result.mass = scene.mass;
  result.colliders = scene.colliders;
  if (!scene.colliders.empty()) result.contact = contact_of(setup, whole);
  return result;
}

double fem_tolerance(const Setup& setup, const RunDescription& run) {
  const double asked = run.solver.tolerance;
  if (!run.fem->any_rounding) return asked;
  const double rounding = rounding_floor(setup.scene, std::numeric_limits<double>::epsilon());
  return std::clamp(8 * rounding, asked, 1e-3);
}

void describe_fem(const Setup& setup, const RunDescription& run, const fem::FemScene& scene,
                  StateHeader& header) {
  header.solver = "fem";
  header.tolerance = fem_tolerance(setup, run);
  header.element = fem::element_name(scene.mesh.element);
  if (!run.holds.empty() || !run.moves.empty()) header.fixed = scene.fixed;
  header.traction = scene.traction;
  if (!run.fem->statics) header.forces = fem_forces(setup, run, scene);
  header.moved = bool(scene.motion);
  if (run.fem->statics) header.path_time = end_of_moves(run);
  if (!scene.colliders.empty())
    header.contact = {{"layer", scene.contact.layer},
                      {"slip_range", scene.contact.slip_range},
                      {"impact_speed", setup.scene.impact_speed}};
  // tetrahedra in place of the grid
  if (!is_tets(scene.mesh.element)) return;
  StateMesh& mesh = header.mesh.emplace();
  mesh.nodes = nodes_with_holders(setup, scene.mesh);
  mesh.nodes.fixed = holders_of_axes(setup, run, scene.mesh, mesh.nodes);
  mesh.corners = scene.mesh.elements;
  mesh.material = scene.mesh.material;
  mesh.mass = fem::ElasticBody(scene.mesh, scene.materials).lumped_mass();
  if (setup.cut_mesh) mesh.fill = scene.mesh.fill, mesh.part = scene.mesh.part;
  mesh.contact_nodes = scene.contact.nodes;
  mesh.contact_weights = scene.contact.weights;
}

std::optional<StatePlastic> state_plastic(const fem::FemScene& scene,
                                          const fem::PlasticHistory& history) {
  if (scene.yields.empty()) return {};
  return StatePlastic{yield_rows(scene.yields), history.Fp_inverse, history.memory};
}

}  // namespace elastogen
