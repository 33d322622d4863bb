// SPDX-License-Identifier: Apache-2.0
#include "scene/pins.hpp"

#include "core/cuda/card.hpp"
#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "mpm_fem/fem/element_mesh.hpp"
#include "voxelize/dependent_nodes.hpp"
#include "voxelize/regions.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kOnBorder = 1e-9;  // of the longest edge, as in regions.cpp

/// What holds only the nodes in a pin, empty where nothing of the run does.
std::string holder_of_nodes(const RunDescription& run) {
  if (method_of(run) == Method::kMpm) return "particles hold";
  if (run.fem && fem::nodes_of(run.fem->element) != 8) return "tetrahedra hold";
  if (run.fem || method_of(run) != Method::kAuto) return "";
  if (run.solver.mode == SolverMode::kPaper) return "the solver 'paper' holds";
  const Device device = run.solver.device;
  if (device == Device::kCuda || (device == Device::kAuto && cuda::has_device()))
    return "the card holds";
  return "";
}

double longest_extent(const Box& box) {
  return std::max({box.extent(0), box.extent(1), box.extent(2)});
}

std::string span_of(const PlacedBox& box) {
  const Vec3 lower = plus(box.lower, box.origin), upper = plus(box.upper, box.origin);
  return fmt::format("{:.4g}..{:.4g}, {:.4g}..{:.4g}, {:.4g}..{:.4g} m", lower[0], upper[0],
                     lower[1], upper[1], lower[2], upper[2]);
}

/// Moves the planes of nodes into those of pins, one an axis: the first one where the others lie in
/// planes of nodes too, else the lowest, whatever their order.
void align_to_pins(const RunDescription& run, const PlacedBox& box, VoxelizeOptions& options) {
  const double h = options.h > 0 ? options.h : longest_extent(box) / options.voxels;
  std::vector<double> planes[3];
  for (const Pin& pin : run.pins) {
    const auto border = border_of(pin.selection, box);
    const auto at = plane(pin.selection, box);
    if (at && reaches(*border, box)) planes[at->first].push_back(at->second);
  }
  for (size_t d = 0; d < 3; ++d) {
    if (planes[d].empty()) continue;
    const double first = planes[d].front();
    const bool all_fit = std::ranges::all_of(planes[d], [&](double place) {
      const double steps = (place - first) / h;
      return std::abs(steps - std::round(steps)) <= kSamePlane;
    });
    options.align[d] = all_fit ? first : *std::ranges::min_element(planes[d]);
  }
}

/// 1 for each node that an option selects, (nodes, 1); warns if there is none.
Array<uint8_t> held_nodes(const char* option, const std::string& text, const Selection& selection,
                          Setup& setup) {
  const PlacedBox& box = setup.body.surface.box;
  Array<uint8_t> selected = select_nodes(setup.scene.grid, selection, box);
  const uint8_t* nodes = selected.data();
  if (std::any_of(nodes, nodes + selected.rows(), [](uint8_t s) { return s != 0; }))
    return selected;
  setup.warnings.push_back(
      fmt::format("{} '{}' holds nothing: no node of the grid lies in it; the asset spans {}",
                  option, text, span_of(box)));
  return selected;
}

/// Pins the nodes in a pin, and those that lie in its planes but for the rounding of the grid.
void pin_nodes(const Pin& pin, const std::optional<Border>& border, Setup& setup) {
  Scene& scene = setup.scene;
  const Array<uint8_t> selected = held_nodes("--pin", pin.text, pin.selection, setup);
  for (int64_t n = 0; n < selected.rows(); ++n) {
    const double* X = scene.grid.rest.row(n);
    scene.pinned(n) |= selected(n);
    if (border && distance(*border, {X[0], X[1], X[2]}) <= kSamePlane * scene.grid.h)
      scene.pinned(n) = kPinnedNode;
  }
}

/// Whether nodes hold a pin where its border lies.
bool fits_grid(const std::optional<Border>& border, const Setup& setup) {
  const VoxelGrid& grid = setup.scene.grid;
  return !border || fits(*border, setup.body.surface.box, grid.h, grid.origin);
}

/// Says once that nodes hold pins whose borders cut voxels.
void say_nodes_hold(const RunDescription& run, Setup& setup) {
  const PlacedBox& box = setup.body.surface.box;
  for (const Pin& pin : run.pins) {
    const std::optional<Border> border = border_of(pin.selection, box);
    if (setup.tets || fits_grid(border, setup) || !reaches(*border, box)) continue;
    setup.warnings.push_back(fmt::format(
        "--pin '{}': its border cuts voxels, of which {} the nodes in it only, so that the body "
        "moves there by a part of what its voxels do; the network on the CPU and finite elements "
        "on "
        "voxels hold it at the border",
        pin.text, holder_of_nodes(run)));
    return;
  }
}

}  // namespace

void add_borders(const RunDescription& run, const PlacedBox& box, VoxelizeOptions& options) {
  if (!holder_of_nodes(run).empty()) return;
  for (const Pin& pin : run.pins)
    if (const auto border = border_of(pin.selection, box)) options.borders.push_back(*border);
  std::ranges::sort(options.borders, [](const Border& a, const Border& b) { return a < b; });
  options.borders.erase(std::unique(options.borders.begin(), options.borders.end()),
                        options.borders.end());
  align_to_pins(run, box, options);
}

void pin(const RunDescription& run, const std::vector<Border>& borders,
         const std::vector<BorderVoxel>& cut, Setup& setup) {
  Scene& scene = setup.scene;
  const PlacedBox& box = setup.body.surface.box;
  scene.pinned = Array<uint8_t>(scene.grid.node_count());
  // pins that the grid fits by their nodes, the others at their borders
  for (const Pin& pin : run.pins) {
    const std::optional<Border> border = border_of(pin.selection, box);
    if (borders.empty() || fits_grid(border, setup)) {
      pin_nodes(pin, borders.empty() ? std::nullopt : border, setup);
      continue;
    }
    const auto number = std::ranges::find(borders, *border) - borders.begin();
    if (std::ranges::any_of(cut, [&](const BorderVoxel& at) { return at.border == number; }))
      setup.borders.push_back(*border);
    else
      setup.warnings.push_back(fmt::format(
          "--pin '{}' holds nothing: nothing of the asset lies in it, or nothing beside "
          "it is free; the asset spans {}",
          pin.text, span_of(box)));
  }
  scene.dependent = dependent_nodes(scene.grid, borders, cut, scene.pinned);
  for (int64_t i = 0; i < scene.dependent.count(); ++i)
    scene.pinned(scene.dependent.node(i)) = kDependentNode;
  if (borders.empty()) say_nodes_hold(run, setup);
  // holds and moves
  for (const Hold& hold : run.holds) held_nodes("--hold", hold.text, hold.selection, setup);
  for (const Move& move : run.moves) held_nodes("--move", move.text, move.selection, setup);
}

void rest_behind(const std::vector<Border>& borders, const PlacedBox& box, In<double> points,
                 Array<double>& weights) {
  if (borders.empty()) return;
  const double margin = kOnBorder * longest_extent(box);
  for_each(points.rows, [&](int64_t p) {
    for (const Border& border : borders)
      if (distance(border, {points(p, 0), points(p, 1), points(p, 2)}) <= margin)
        std::fill_n(weights.row(p), 8, 0.0);
  });
}

}  // namespace elastogen
