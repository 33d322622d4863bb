// SPDX-License-Identifier: Apache-2.0
#include "scene/loads.hpp"

#include "core/error.hpp"
#include "mpm_fem/fem/surface_load.hpp"
#include "scene/pins.hpp"
#include "voxelize/voxelize.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace elastogen {

Array<uint8_t> with_middles(const Array<uint8_t>& grid_nodes, const fem::ElementMesh& mesh) {
  constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  Array<uint8_t> nodes(mesh.rest.rows());
  std::copy_n(grid_nodes.data(), grid_nodes.rows(), nodes.data());
  for (int64_t e = 0; e < mesh.elements.rows() && mesh.elements.cols() == 10; ++e)
    for (int k = 0; k < 6; ++k) {
      const int32_t a = mesh.elements(e, kEdges[k][0]), b = mesh.elements(e, kEdges[k][1]);
      if (grid_nodes(a) && grid_nodes(b)) nodes(mesh.elements(e, 4 + k)) = 1;
    }
  return nodes;
}

std::vector<TimedForce> timed_forces(const Setup& setup, const RunDescription& run,
                                     const fem::ElementMesh& mesh, const Array<double>& mass) {
  std::vector<TimedForce> forces;
  for (const Force& force : run.forces) {
    const Array<uint8_t> nodes = with_middles(selected_nodes(setup, force.selection), mesh);
    double all = 0;
    for (int64_t n = 0; n < nodes.rows(); ++n) all += nodes(n) ? mass(n) : 0;
    if (!(all > 0))
      throw Error(fmt::format("--force '{}': no node of the grid lies in it; the asset spans {}",
                              force.text, span_of(setup.body.surface.box)));
    TimedForce& timed = forces.emplace_back();
    timed.force = force.force;
    timed.share = Array<double>(nodes.rows());
    for (int64_t n = 0; n < nodes.rows(); ++n) timed.share(n) = nodes(n) ? mass(n) / all : 0;
  }
  return forces;
}

void add_forces(const RunDescription& run, Setup& setup) {
  Scene& scene = setup.scene;
  if (!run.tractions.empty() || !run.forces.empty()) {
    const fem::ElementMesh mesh = fem::voxel_mesh(scene, fem::Element::kVoxel);
    scene.load = surface_loads(setup, run, mesh);
    scene.forces = timed_forces(setup, run, mesh, scene.mass);
  }
}

void add_wind(const RunDescription& run, Setup& setup) {
  if (run.wind.keys.empty()) return;
  ELASTOGEN_CHECK(!run.fem || !run.fem->statics,
                  "--static finds no equilibrium in wind, got --wind '", run.wind_text, "'");
  Scene& scene = setup.scene;
  scene.wind.velocity = run.wind;
  scene.wind.share = setup.asset.closed ? 0.5 : 1;
  // what presses on parts behind borders goes to what holds them
  const auto is_held = [&](const Vec3& place) {
    return std::ranges::any_of(
        setup.borders, [&](const HeldBorder& held) { return distance(held.border, place) <= 0; });
  };
  add_wind_surface(scene.grid, setup.body.surface, is_held, scene.wind);
}

Array<double> surface_loads(const Setup& setup, const RunDescription& run,
                            const fem::ElementMesh& mesh) {
  Array<double> sum;
  for (const Traction& traction : run.tractions) {
    const Array<uint8_t> nodes = with_middles(selected_nodes(setup, traction.selection), mesh);
    const Array<double> load = traction.pressure
                                   ? fem::pressure_load(mesh, nodes, *traction.pressure)
                                   : fem::surface_load(mesh, nodes, traction.force);
    if (load.empty())
      throw Error(fmt::format(
          "--traction '{}': no face of the body has all its nodes in the selection; the asset "
          "spans {}",
          traction.text, span_of(setup.body.surface.box)));
    if (sum.empty()) sum = Array<double>(load.rows(), 3);
    for (int64_t k = 0; k < load.size(); ++k) sum.data()[k] += load.data()[k];
  }
  return sum;
}

}  // namespace elastogen
