// SPDX-License-Identifier: Apache-2.0
#include "scene/fem_holders.hpp"

#include "mpm_fem/fem/mesh_part.hpp"
#include "mpm_fem/solve/mass_matrix.hpp"

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

/// M 1 by one component of the nodal vectors.
Array<double> row_sums(const fem::FemScene& scene) {
  const fem::MassMatrix mass(scene, fem::ElasticBody(scene.mesh, scene.materials));
  const int64_t nodes = scene.mesh.rest.rows();
  Array<double> ones(nodes, 3), sums(nodes, 3), result(nodes);
  ones.fill(1);
  mass.multiply(ones.data(), sums.data());
  for (int64_t n = 0; n < nodes; ++n) result(n) = sums(n, 0);
  return result;
}

/// The mass that elements with all their nodes pinned give each node.
Array<double> held_mass(const fem::FemScene& scene, const Scene& nodes) {
  std::vector<int64_t> held;
  for (int64_t e = 0; e < scene.mesh.elements.rows(); ++e) {
    const int32_t* corner = scene.mesh.elements.row(e);
    if (std::all_of(corner, corner + scene.mesh.elements.cols(),
                    [&](int32_t n) { return nodes.pinned(n) == kPinnedNode; }))
      held.push_back(e);
  }
  if (held.empty()) return Array<double>(scene.mesh.rest.rows());
  fem::FemScene part;
  part.mesh = some_elements(scene.mesh, held);
  part.materials = scene.materials;
  part.mass_kind = scene.mass_kind;
  return row_sums(part);
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

FemHolders::FemHolders(const Setup& setup, const fem::FemScene& scene)
    : scene_(scene), nodes_(nodes_with_holders(setup, scene.mesh)), held_(nodes_) {
  if (nodes_.holders.empty()) return;
  held_mass_ = held_mass(scene, nodes_);
  mass_ = row_sums(scene);
}

std::vector<Reaction> FemHolders::of_forces(Array<double> forces, In<double> u) const {
  // what is held whole weighs on its holder by itself
  for (int64_t n = 0; n < forces.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      if (nodes_.pinned(n) == kPinnedNode)
        forces(n, d) += held_mass_(n) * scene_.gravity[size_t(d)];
  return held_.reactions(forces.data(), u.data, nullptr);
}

std::vector<Reaction> FemHolders::reactions(Array<double> forces, In<double> u, double time) const {
  if (nodes_.holders.empty()) return {};
  const Array<double> load = fem::applied_force(scene_, time, 1);
  for (int64_t n = 0; n < forces.rows(); ++n)
    for (int d = 0; d < 3; ++d)
      if (nodes_.pinned(n) == kPinnedNode)
        forces(n, d) -= load(n, d) + mass_(n) * scene_.gravity[size_t(d)];
  return of_forces(std::move(forces), u);
}

std::vector<Reaction> FemHolders::reactions(const fem::StaticResult& result) const {
  if (nodes_.holders.empty() || !result.converged) return {};
  return of_forces(result.reaction, result.u);
}

}  // namespace elastogen
