// SPDX-License-Identifier: Apache-2.0
#include "scene/tet_pins.hpp"

#include "mpm_fem/fem/cut_tets.hpp"
#include "mpm_fem/fem/dependent_tet_nodes.hpp"
#include "scene/fem_holders.hpp"
#include "scene/fem_scene.hpp"
#include "scene/moved_points.hpp"
#include "scene/pins.hpp"
#include "voxelize/regions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kWhole = 1e-12;  // share of a voxel that is no cut

/// The selections of the holders of a run, in their order.
std::vector<const Selection*> held_selections(const RunDescription& run) {
  std::vector<const Selection*> selections;
  for (const Pin& pin : run.pins) selections.push_back(&pin.selection);
  for (const Move& move : run.moves) selections.push_back(&move.selection);
  return selections;
}

/// Borders that cut elements, and the holder of each.
struct CuttingBorders {
  std::vector<Border> borders;
  std::vector<int32_t> holders;
};

/// Of voxels those that the grid does not fit, else those that cut tetrahedra of the file.
CuttingBorders cutting_borders(const std::vector<const Selection*>& selections, const Setup& setup,
                               const fem::ElementMesh& mesh) {
  CuttingBorders cutting;
  const auto add = [&](const Border& border, int32_t holder) {
    if (std::ranges::find(cutting.borders, border) != cutting.borders.end()) return;
    cutting.borders.push_back(border);
    cutting.holders.push_back(holder);
  };
  for (const HeldBorder& held : setup.borders) add(held.border, held.holder);
  for (size_t k = 0; k < selections.size() && setup.tets; ++k) {
    const std::optional<Border> border = border_of(*selections[k], setup.body.surface.box);
    if (border && fem::cuts(mesh, *border)) add(*border, int32_t(k));
  }
  return cutting;
}

/// Gives the tetrahedra of each voxel that is cut the free share of the voxel.
void share_voxels(const fem::ElementMesh& whole, const VoxelGrid& grid, fem::CutTets& cut) {
  const int64_t per_voxel = whole.elements.rows() / grid.voxel_count();
  std::vector<double> mean(static_cast<size_t>(grid.voxel_count()));
  const auto share = [&](size_t k) {
    return cut.mesh.fill(int64_t(k)) / whole.fill(cut.number[k]);
  };
  for (size_t k = 0; k < cut.number.size(); ++k)
    mean[size_t(cut.number[k] / per_voxel)] += share(k) / double(per_voxel);
  for (size_t k = 0; k < cut.number.size(); ++k) {
    const double of_voxel = mean[size_t(cut.number[k] / per_voxel)];
    if (of_voxel < 1 - kWhole) cut.mesh.fill(int64_t(k)) /= of_voxel;
  }
}

/// 1 for each node of the elements of a mesh, (nodes, 1).
Array<uint8_t> nodes_in(const fem::ElementMesh& mesh) {
  Array<uint8_t> used(mesh.rest.rows());
  for (int64_t k = 0; k < mesh.elements.size(); ++k) used(mesh.elements.data()[k]) = 1;
  return used;
}

/// A selection that the mesh fits; of a part of the asset with its nodes.
struct HeldSelection {
  const Selection* selection;
  Array<uint8_t> nodes;
};

std::vector<HeldSelection> fitted_selections(const CuttingBorders& cutting,
                                             const std::vector<const Selection*>& selections,
                                             const Setup& setup) {
  std::vector<HeldSelection> fitted;
  for (size_t k = 0; k < selections.size(); ++k) {
    if (std::ranges::find(cutting.holders, int32_t(k)) != cutting.holders.end()) continue;
    const bool is_place = selections[k]->is_place();
    fitted.push_back(
        {selections[k], is_place ? Array<uint8_t>() : selected_nodes(setup, *selections[k])});
  }
  return fitted;
}

/// Frees the nodes that are behind borders but belong to elements that these cut; pins those on borders,
/// and those that belong to no element any more.
void sort_nodes(const CuttingBorders& cutting, const std::vector<const Selection*>& selections,
                const Setup& setup, const fem::ElementMesh& mesh, Scene& nodes) {
  const double margin = fem::kNodeOnBorder * setup.longest_edge;
  const Array<uint8_t> used = nodes_in(mesh);
  const std::vector<HeldSelection> fitted = fitted_selections(cutting, selections, setup);
  for (int64_t n = 0; n < used.rows(); ++n) {
    // the nearest border
    const Vec3 X = {mesh.rest(n, 0), mesh.rest(n, 1), mesh.rest(n, 2)};
    const auto nearest = std::ranges::min_element(
        cutting.borders, {}, [&](const Border& border) { return distance(border, X); });
    const double d = distance(*nearest, X);
    const bool is_behind = d < -margin, is_on = std::abs(d) <= margin;
    // whether another pin, which the mesh fits, has the node
    const bool fits = std::ranges::any_of(fitted, [&](const HeldSelection& of) {
      return of.nodes.empty() ? contains(*of.selection, X, setup.body.surface.box)
                              : n < of.nodes.rows() && of.nodes(n) != 0;
    });
    if (used(n) && is_behind && !fits) nodes.pinned(n) = kFreeNode, nodes.holder(n) = -1;
    if (nodes.pinned(n) || (used(n) && !is_on)) continue;
    nodes.pinned(n) = kPinnedNode;
    nodes.holder(n) = cutting.holders[size_t(nearest - cutting.borders.begin())];
  }
}

/// Adds the nodes that follow others.
void add_dependent(const CuttingBorders& cutting, const fem::CutTets& cut, Scene& nodes) {
  std::vector<int32_t> border_of_node;
  nodes.dependent =
      fem::dependent_tet_nodes(cut.mesh, cutting.borders, cut.cut, nodes.pinned, &border_of_node);
  for (int64_t i = 0; i < nodes.dependent.count(); ++i) {
    const int32_t n = nodes.dependent.node(i);
    nodes.pinned(n) = kDependentNode;
    nodes.holder(n) = cutting.holders[size_t(border_of_node[size_t(i)])];
  }
}

/// Warns of holders without a node.
void say_empty(const Scene& nodes, Setup& setup) {
  std::vector<bool> holds(nodes.holders.size());
  for (int64_t n = 0; n < nodes.holder.rows(); ++n)
    if (nodes.holder(n) >= 0) holds[size_t(nodes.holder(n))] = true;
  for (size_t k = 0; k < holds.size(); ++k)
    if (!holds[k])
      setup.warnings.push_back(fmt::format(
          "{} holds nothing: nothing of the mesh lies in it, or another one holds that; the "
          "asset spans {}",
          nodes.holders[k].name, span_of(setup.body.surface.box)));
}

/// Whether finite elements of a run are tetrahedra.
bool steps_tets(const Setup& setup, const RunDescription& run) {
  if (!run.fem) return false;
  const int nodes = fem::nodes_of(setup.tets ? setup.tets->element : run.fem->element);
  return nodes == 4 || nodes == 10;
}

/// The nodes of a mesh with pinned ones alone.
Scene pinned_nodes(const Setup& setup, const fem::ElementMesh& mesh) {
  Scene nodes = nodes_with_holders(setup, mesh);
  nodes.dependent = {};
  for (int64_t n = 0; n < nodes.pinned.rows(); ++n)
    if (nodes.pinned(n) == kDependentNode) nodes.pinned(n) = kFreeNode, nodes.holder(n) = -1;
  return nodes;
}

}  // namespace

void hold_tets(const RunDescription& run, Setup& setup) {
  if (!steps_tets(setup, run) || setup.scene.holders.empty()) return;
  const fem::ElementMesh mesh = whole_mesh(setup, run);
  const std::vector<const Selection*> selections = held_selections(run);
  const CuttingBorders cutting = cutting_borders(selections, setup, mesh);
  fem::CutTets cut = fem::cut_tets(mesh, cutting.borders);
  Scene nodes = pinned_nodes(setup, mesh);
  // where the mesh fits them, or all of it is held, nodes hold it
  if (cutting.borders.empty() || cut.mesh.elements.rows() == 0) {
    if (setup.tets) say_empty(nodes, setup);
    return;
  }
  if (!setup.tets) share_voxels(mesh, setup.scene.grid, cut);
  sort_nodes(cutting, selections, setup, cut.mesh, nodes);
  add_dependent(cutting, cut, nodes);
  if (setup.tets) {
    for (size_t b = 0; b < cutting.borders.size(); ++b)
      setup.borders.push_back({cutting.borders[b], cutting.holders[b]});
    say_empty(nodes, setup);
  }
  // the nodes of the grid, and no contact behind borders
  setup.scene.dependent = {};
  std::copy_n(nodes.pinned.data(), setup.scene.pinned.rows(), setup.scene.pinned.data());
  const std::vector<HeldPoint> behind =
      points_behind(setup.borders, setup.body.surface.box, setup.scene.surface.position);
  for (const HeldPoint& held : behind) setup.scene.surface.area(held.point) = 0;
  if (setup.tets) note_moved(behind, setup);
  setup.cut_mesh = CutMesh{std::move(cut.mesh), std::move(nodes)};
}

}  // namespace elastogen
