// SPDX-License-Identifier: Apache-2.0
#include "cli/fem_stepper.hpp"

#include "cli/fem_boundary.hpp"
#include "mpm_fem/fem/elastic_body.hpp"
#include "mpm_fem/fem/point_location.hpp"
#include "mpm_fem/fem/voxel_tets.hpp"
#include "mpm_fem/integrators/implicit_fem.hpp"

#include <algorithm>
#include <limits>

namespace elastogen {
namespace {

bool is_tets(fem::Element element) {
  return fem::nodes_of(element) != 8;
}

fem::ElementMesh mesh_of(const Scene& scene, fem::Element element) {
  if (!is_tets(element)) return fem::voxel_mesh(scene, element);
  fem::ElementMesh mesh = fem::voxel_tets(scene, fem::VoxelSplit::kSix);
  if (element != fem::Element::kTet4) mesh = fem::quadratic(mesh);
  mesh.element = element;
  return mesh;
}

/// The points of the voxels' surface, carried by the tetrahedra of their voxel, or the nodes of
/// the surface of tetrahedra.
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

/// Materials whose densities give the voxels' fills the mass of the scene, which is that of the
/// asset's volume.
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

fem::Scheme scheme_of(const Scene& scene, const FemOptions& options) {
  if (options.newmark) return fem::Scheme::kNewmark;
  return scene.scheme == TimeScheme::kBdf2 ? fem::Scheme::kBdf2 : fem::Scheme::kEuler;
}

Array<double> difference(const Array<double>& a, const Array<double>& b) {
  Array<double> result = a;
  for (int64_t k = 0; k < a.size(); ++k) result.data()[k] -= b.data()[k];
  return result;
}

Array<double> sum(const Array<double>& a, const Array<double>& b) {
  Array<double> result = a;
  for (int64_t k = 0; k < a.size(); ++k) result.data()[k] += b.data()[k];
  return result;
}

class FemStepper : public Stepper {
 public:
  FemStepper(const Setup& setup, const AnimateOptions& options, std::function<bool()> interrupted)
      : setup_(setup),
        options_(options),
        interrupted_(std::move(interrupted)),
        scene_(fem_scene(setup, options)),
        solver_(scene_, {.tolerance = fem_tolerance(setup, options)}) {}

  State start(const StartMotion& motion) const override;
  StepReport step(State& state) override;
  Span<const double> residual() const override { return solver_.residual(); }
  void describe(StateHeader& header) const override {
    describe_fem(setup_, options_, scene_, header);
    if (options_.fem->newmark) header.scheme = "newmark";
  }

 private:
  fem::FemState fem_state(const State& state) const;

  const Setup& setup_;
  const AnimateOptions& options_;
  std::function<bool()> interrupted_;
  fem::FemScene scene_;
  fem::ImplicitFem solver_;
  Array<double> acceleration_;  // of Newmark, after the last step
};

State FemStepper::start(const StartMotion& motion) const {
  Scene nodes;  // only what initial_state looks at
  nodes.grid.rest = scene_.mesh.rest;
  nodes.mass = solver_.potential().mass().nodal();
  nodes.pinned = pinned_nodes(setup_.scene, scene_.mesh);
  State state = initial_state(nodes, motion);
  for (int64_t k = 0; k < state.v.size(); ++k)
    if (scene_.fixed.data()[k]) state.v.data()[k] = 0;
  return state;
}

fem::FemState FemStepper::fem_state(const State& state) const {
  fem::FemState result;
  result.u = difference(state.x, scene_.mesh.rest);
  result.v = state.v;
  if (!state.x_before.empty()) {
    result.u_before = difference(state.x_before, scene_.mesh.rest);
    result.v_before = state.v_before;
  }
  if (state.steps > 0) result.a = acceleration_;
  result.time = state.time;
  result.steps = state.steps;
  return result;
}

StepReport FemStepper::step(State& state) {
  StepReport report;
  report.interrupted = interrupted_();
  if (report.interrupted) return report;
  fem::FemState next = fem_state(state);
  report = solver_.step(next);
  if (!report.finite) return report;
  acceleration_ = next.a;
  state.x_before = std::move(state.x);
  state.v_before = std::move(state.v);
  state.x = sum(next.u, scene_.mesh.rest);
  state.v = std::move(next.v);
  state.time = next.time;
  state.steps = next.steps;
  return report;
}

}  // namespace

fem::FemScene fem_scene(const Setup& setup, const AnimateOptions& options) {
  const Scene& scene = setup.scene;
  const FemOptions& fem = *options.fem;
  fem::FemScene result;
  result.mesh = setup.tets ? *setup.tets : mesh_of(scene, fem.element);
  result.materials = setup.tets ? scene.materials : materials_of(scene);
  result.gravity = scene.gravity;
  add_boundary(setup, options, result);
  result.dt = scene.dt;
  result.scheme = scheme_of(scene, fem);
  result.mass_kind = fem.mass;
  const bool lumped = fem.mass == fem::Mass::kLumped;
  if (lumped && !is_tets(result.mesh.element)) result.mass = scene.mass;
  result.colliders = scene.colliders;
  if (!scene.colliders.empty()) result.contact = contact_of(setup, result.mesh);
  return result;
}

double fem_tolerance(const Setup& setup, const AnimateOptions& options) {
  const double asked = options.solver.tolerance;
  if (!options.fem->any_rounding) return asked;
  const double rounding = rounding_floor(setup.scene, std::numeric_limits<double>::epsilon());
  return std::clamp(8 * rounding, asked, 1e-3);
}

void describe_fem(const Setup& setup, const AnimateOptions& options, const fem::FemScene& scene,
                  StateHeader& header) {
  header.solver = "fem";
  header.tolerance = fem_tolerance(setup, options);
  header.element = fem::element_name(scene.mesh.element);
  if (!options.holds.empty() || !options.moves.empty()) header.fixed = scene.fixed;
  header.traction = scene.traction;
  if (!scene.colliders.empty())
    header.contact = {{"layer", scene.contact.layer}, {"slip_range", scene.contact.slip_range}};
  if (!is_tets(scene.mesh.element)) return;
  StateMesh& mesh = header.mesh.emplace();
  mesh.rest = scene.mesh.rest;
  mesh.corners = scene.mesh.elements;
  mesh.material = scene.mesh.material;
  mesh.mass = fem::ElasticBody(scene.mesh, scene.materials).lumped_mass();
  mesh.pinned = pinned_nodes(setup.scene, scene.mesh);
  mesh.contact_nodes = scene.contact.nodes;
  mesh.contact_weights = scene.contact.weights;
}

std::unique_ptr<Stepper> make_fem_stepper(const Setup& setup, const AnimateOptions& options,
                                          std::function<bool()> interrupted) {
  return std::make_unique<FemStepper>(setup, options, std::move(interrupted));
}

}  // namespace elastogen
