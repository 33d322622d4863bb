// SPDX-License-Identifier: Apache-2.0
#include "scene/fem_holders.hpp"

#include "core/vec3.hpp"
#include "mpm_fem/fem/mesh_part.hpp"
#include "scene/loads.hpp"
#include "scene/pins.hpp"

#include <algorithm>

namespace elastogen {
namespace {

/// Gives middles of edges between pinned nodes to the holder of the first one.
void pin_middles(const fem::ElementMesh& mesh, Scene& nodes) {
  constexpr int kEdges[6][2] = {{0, 1}, {1, 2}, {0, 2}, {0, 3}, {1, 3}, {2, 3}};
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    for (int k = 0; k < 6; ++k) {
      const int32_t a = mesh.elements(e, kEdges[k][0]), b = mesh.elements(e, kEdges[k][1]),
                    middle = mesh.elements(e, 4 + k);
      if (nodes.pinned(a) != kPinnedNode || nodes.pinned(b) != kPinnedNode) continue;
      nodes.pinned(middle) = kPinnedNode;
      if (nodes.holder(middle) < 0) nodes.holder(middle) = nodes.holder(a);
    }
}

fem::MassMatrix mass_of(const fem::FemScene& scene) {
  return {scene, fem::ElasticBody(scene.mesh, scene.materials)};
}

/// That of the elements with all their nodes pinned.
std::optional<fem::MassMatrix> held_mass(const fem::FemScene& scene, const Scene& nodes) {
  std::vector<int64_t> held;
  for (int64_t e = 0; e < scene.mesh.elements.rows(); ++e) {
    const int32_t* corner = scene.mesh.elements.row(e);
    if (std::all_of(corner, corner + scene.mesh.elements.cols(),
                    [&](int32_t n) { return nodes.pinned(n) == kPinnedNode; }))
      held.push_back(e);
  }
  if (held.empty()) return {};
  fem::FemScene part;
  part.mesh = some_elements(scene.mesh, held);
  part.materials = scene.materials;
  part.mass_kind = scene.mass_kind;
  return mass_of(part);
}

/// M a, (nodes, 3); 0 without a mass.
Array<double> product(const std::optional<fem::MassMatrix>& mass, const Array<double>& a) {
  Array<double> result(a.rows(), 3);
  if (mass) mass->multiply(a.data(), result.data());
  return result;
}

/// What holds the nodes of a mesh, along axes too.
Scene all_held_nodes(const Setup& setup, const RunDescription& run, const fem::ElementMesh& mesh) {
  Scene nodes = nodes_with_holders(setup, mesh);
  nodes.fixed = holders_of_axes(setup, run, mesh, nodes);
  return nodes;
}

}  // namespace

Scene nodes_with_holders(const Setup& setup, const fem::ElementMesh& mesh) {
  if (setup.cut_mesh) return setup.cut_mesh->nodes;
  const Scene& grid = setup.scene;
  Scene nodes;
  nodes.grid.rest = mesh.rest;
  nodes.gravity = grid.gravity;
  nodes.holders = grid.holders;
  nodes.dependent = grid.dependent;
  nodes.pinned = Array<uint8_t>(mesh.rest.rows());
  nodes.holder = Array<int32_t>(mesh.rest.rows());
  std::fill_n(nodes.holder.data(), nodes.holder.rows(), -1);
  std::copy_n(grid.pinned.data(), grid.pinned.rows(), nodes.pinned.data());
  std::copy_n(grid.holder.data(), grid.holder.rows(), nodes.holder.data());
  if (mesh.elements.cols() == 10) pin_middles(mesh, nodes);
  return nodes;
}

Array<int32_t> holders_of_axes(const Setup& setup, const RunDescription& run,
                               const fem::ElementMesh& mesh, const Scene& nodes) {
  if (run.holds.empty()) return {};
  Array<int32_t> fixed(mesh.rest.rows(), 3);
  fixed.fill(-1);
  auto holder = int32_t(nodes.holders.size() - run.holds.size());
  for (const Hold& hold : run.holds) {
    const Array<uint8_t> held = with_middles(selected_nodes(setup, hold.selection), mesh);
    for (int64_t n = 0; n < held.rows(); ++n)
      for (int d = 0; d < 3; ++d)
        if (held(n) && hold.axes[size_t(d)] && nodes.pinned(n) == kFreeNode && fixed(n, d) < 0)
          fixed(n, d) = holder;
    ++holder;
  }
  return fixed;
}

FemHolders::FemHolders(const Setup& setup, const RunDescription& run, const fem::FemScene& scene)
    : scene_(scene), nodes_(all_held_nodes(setup, run, scene.mesh)), held_(nodes_) {
  if (nodes_.holders.empty()) return;
  mass_ = mass_of(scene);
  held_mass_ = held_mass(scene, nodes_);
  Array<double> ones(scene.mesh.rest.rows(), 3);
  ones.fill(1);
  weights_ = product(mass_, ones);
  held_weights_ = product(held_mass_, ones);
  for (Array<double>* weights : {&weights_, &held_weights_})
    for (int64_t k = 0; k < weights->size(); ++k)
      weights->data()[k] *= scene.gravity[size_t(k % 3)];
}

bool FemHolders::is_held(int64_t n, int axis) const {
  return nodes_.pinned(n) == kPinnedNode || (!nodes_.fixed.empty() && nodes_.fixed(n, axis) >= 0);
}

/// What holds whole elements carries their weight and inertia by itself.
std::vector<Reaction> FemHolders::of_forces(Array<double> forces, In<double> u) const {
  for (int64_t n = 0; n < forces.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      if (is_held(n, d)) forces(n, d) += held_weights_(n, d);
  return held_.reactions(forces.data(), u.data, nullptr);
}

/// Adds the inertia of pinned nodes that move, M a.
void FemHolders::add_inertia(In<double> u, Array<double>& forces) const {
  if (!held_.move()) return;
  Array<double> a(forces.rows(), 3);
  for (int64_t n = 0; n < a.rows(); ++n) {
    if (nodes_.pinned(n) != kPinnedNode || nodes_.holder(n) < 0) continue;
    const double* X = scene_.mesh.rest.row(n);
    const Vec3 x = {X[0] + u(n, 0), X[1] + u(n, 1), X[2] + u(n, 2)};
    std::ranges::copy(held_.rates()[size_t(nodes_.holder(n))].acceleration(x), a.row(n));
  }
  const Array<double> all = product(mass_, a), held = product(held_mass_, a);
  for (int64_t n = 0; n < a.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      if (is_held(n, d)) forces(n, d) += all(n, d) - held(n, d);
}

std::vector<Reaction> FemHolders::reactions(Array<double> forces, In<double> loads, In<double> u,
                                            double time) {
  if (nodes_.holders.empty()) return {};
  held_.set_time(time);
  for (int64_t n = 0; n < forces.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      if (is_held(n, d)) forces(n, d) -= loads(n, d) + weights_(n, d);
  add_inertia(u, forces);
  return of_forces(std::move(forces), u);
}

std::vector<Reaction> FemHolders::reactions(const fem::StaticResult& result) const {
  if (nodes_.holders.empty() || !result.converged) return {};
  return of_forces(result.reaction, result.u);
}

}  // namespace elastogen
