// SPDX-License-Identifier: Apache-2.0
#include "scene/pins.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "voxelize/dependent_nodes.hpp"
#include "voxelize/thin_cuts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kOnBorder = 1e-9;  // of the longest edge, as in regions.cpp

/// A pin or a move.
struct HeldPart {
  std::string option;  // as it was typed
  const Selection* selection;
  Holder holder;
};

/// What holds only the nodes in a pin, empty where nothing of the run does.
std::string holder_of_nodes(const RunDescription& run) {
  if (method_of(run) == Method::kMpm) return "particles hold";
  if (run.fem || method_of(run) != Method::kAuto) return "";
  if (run.solver.mode == SolverMode::kPaper) return "the solver 'paper' holds";
  return "";
}

double longest_extent(const Box& box) {
  return std::max({box.extent(0), box.extent(1), box.extent(2)});
}

/// Pins, then moves.
std::vector<HeldPart> held_parts(const RunDescription& run, const PlacedBox& box) {
  std::vector<HeldPart> parts;
  for (const Pin& pin : run.pins)
    parts.push_back({fmt::format("--pin '{}'", pin.text), &pin.selection, {}});
  for (const Move& move : run.moves)
    parts.push_back({fmt::format("--move '{}'", move.text), &move.selection, holder_of(move, box)});
  for (HeldPart& part : parts) part.holder.name = part.option;
  return parts;
}

/// Moves the planes of nodes into those of pins and moves, one an axis: the first one where the
/// others lie in planes of nodes too, else the lowest, whatever their order.
void align_to_pins(const RunDescription& run, const PlacedBox& box, VoxelizeOptions& options) {
  const double h = options.h > 0 ? options.h : longest_extent(box) / options.voxels;
  std::vector<double> planes[3];
  for (const HeldPart& part : held_parts(run, box)) {
    const auto border = border_of(*part.selection, box);
    const auto at = plane(*part.selection, box);
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

/// Gives a node to a holder. @throws Error (usage) if another one has it and one of them moves.
void take_node(int64_t n, int32_t holder, Scene& scene) {
  const int32_t before = scene.holder(n);
  if (before >= 0 && before != holder &&
      (scene.holders[size_t(before)].moves() || scene.holders[size_t(holder)].moves()))
    throw Error(fmt::format(
        "{} and {} contradict each other: both have the node at ({:.4g}, {:.4g}, {:.4g}) m",
        scene.holders[size_t(before)].name, scene.holders[size_t(holder)].name,
        scene.grid.rest(n, 0), scene.grid.rest(n, 1), scene.grid.rest(n, 2)));
  if (before < 0) scene.holder(n) = holder;
  scene.pinned(n) = kPinnedNode;
}

/// Pins the nodes in a part, and those that lie in its planes but for the rounding of the grid. Notes
/// the points of a part of the asset.
void pin_nodes(const HeldPart& part, int32_t holder, const std::optional<Border>& border,
               bool may_be_empty, Setup& setup) {
  Scene& scene = setup.scene;
  const Array<uint8_t> selected = may_be_empty ? selected_nodes(setup, *part.selection)
                                               : held_nodes(part.option, *part.selection, setup);
  for (int64_t n = 0; n < selected.rows(); ++n) {
    const double* X = scene.grid.rest.row(n);
    if (selected(n) ||
        (border && distance(*border, {X[0], X[1], X[2]}) <= kSamePlane * scene.grid.h))
      take_node(n, holder, scene);
  }
  for (int64_t p = 0; p < setup.body.carried.rows() && !part.selection->is_place(); ++p)
    if (has_point(setup, *part.selection, p)) setup.held_points.push_back({p, holder});
}

/// The largest distance from a border of the nodes behind it that share a voxel with one in front [m].
double border_shift(const Border& border, const VoxelGrid& grid) {
  double largest = 0;
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    double behind = 0;
    bool is_cut = false;
    for (int c = 0; c < 8; ++c) {
      const double* X = grid.rest.row(grid.corners(v, c));
      const double d = distance(border, {X[0], X[1], X[2]});
      is_cut |= d > 0;
      behind = std::max(behind, -d);
    }
    if (is_cut) largest = std::max(largest, behind);
  }
  return largest;
}

/// Says once that nodes hold parts whose borders cut voxels.
void say_nodes_hold(const RunDescription& run, Setup& setup) {
  const PlacedBox& box = setup.body.surface.box;
  const VoxelGrid& grid = setup.scene.grid;
  for (const HeldPart& part : held_parts(run, box)) {
    const std::optional<Border> border = border_of(*part.selection, box);
    if (setup.tets || fits_grid(border, setup) || !reaches(*border, box)) continue;
    const double shift = border_shift(*border, grid);
    setup.warnings.push_back(fmt::format(
        "{}: its border cuts voxels, of which {} the nodes in it only, so that it lies up to "
        "{:.3g} m "
        "({:.2g} voxels) too far back; the network and finite elements hold the body at the border",
        part.option, holder_of_nodes(run), shift, shift / grid.h));
    return;
  }
}

/// @throws Error (usage) naming two parts, one of which moves, that have a point of the asset in common.
void check_apart(const std::vector<HeldPart>& parts, const Setup& setup) {
  const Array<double>& points = setup.body.carried;
  for (size_t a = 0; a < parts.size(); ++a)
    for (size_t b = 0; b < a; ++b)
      for (int64_t p = 0; p < points.rows(); ++p) {
        if (!parts[a].holder.moves() && !parts[b].holder.moves()) break;
        if (!has_point(setup, *parts[a].selection, p) || !has_point(setup, *parts[b].selection, p))
          continue;
        throw Error(fmt::format(
            "{} and {} contradict each other: both have the point ({:.4g}, {:.4g}, {:.4g}) m",
            parts[b].option, parts[a].option, points(p, 0), points(p, 1), points(p, 2)));
      }
}

/// Gives a border to a holder. @throws Error (usage) if another one has it and one of them moves.
void claim_border(int32_t holder, int32_t& owner, const Scene& scene) {
  if (owner >= 0 && (scene.holders[size_t(owner)].moves() || scene.holders[size_t(holder)].moves()))
    throw Error(fmt::format("{} and {} contradict each other: both have the same border",
                            scene.holders[size_t(owner)].name, scene.holders[size_t(holder)].name));
  if (owner < 0) owner = holder;
}

/// Says where voxels are too large for what is held.
void say_coarse(const std::vector<HeldBorder>& borders, Setup& setup) {
  constexpr double kLeastRadius = 2;  // of balls [voxel edges]
  const Scene& scene = setup.scene;
  for (const HeldBorder& held : borders) {
    const double radius = held.border.radius / scene.grid.h;
    if (radius <= 0 || radius >= kLeastRadius) continue;
    setup.warnings.push_back(
        fmt::format("{}: its radius is {:.2g} voxels; below 2 what is beside it moves with an "
                    "error of a tenth or more",
                    scene.holders[size_t(held.holder)].name, radius));
  }
  int64_t still = 0;
  for (int64_t i = 0; i < scene.dependent.count(); ++i)
    still += scene.dependent.parents(i).rows == 0;
  if (still > 0)
    setup.warnings.push_back(
        fmt::format("{} nodes between borders of pins hold still: in gaps below two voxels the "
                    "body hardly moves",
                    still));
}

/// Adds the nodes that follow others at borders that cut voxels.
void add_dependent(const std::vector<Border>& borders, const std::vector<BorderVoxel>& cut,
                   const std::vector<int32_t>& holder_of_border, Scene& scene) {
  std::vector<int32_t> border_of_node;
  scene.dependent = dependent_nodes(scene.grid, borders, cut, scene.pinned, &border_of_node);
  for (int64_t i = 0; i < scene.dependent.count(); ++i) {
    const int32_t n = scene.dependent.node(i);
    scene.pinned(n) = kDependentNode;
    scene.holder(n) = holder_of_border[size_t(border_of_node[size_t(i)])];
  }
  join_thin_cuts(borders, cut, scene.dependent, scene.grid);
}

}  // namespace

Array<uint8_t> held_nodes(const std::string& option, const Selection& selection, Setup& setup) {
  Array<uint8_t> selected = selected_nodes(setup, selection);
  const uint8_t* nodes = selected.data();
  if (std::any_of(nodes, nodes + selected.rows(), [](uint8_t s) { return s != 0; }))
    return selected;
  setup.warnings.push_back(
      selection.is_place()
          ? fmt::format("{} holds nothing: no node of the grid lies in it; the asset spans {}",
                        option, span_of(setup.body.surface.box))
          : fmt::format("{} holds nothing: no voxel and no point belongs to it", option));
  return selected;
}

bool fits_grid(const std::optional<Border>& border, const Setup& setup) {
  const VoxelGrid& grid = setup.scene.grid;
  return !border || fits(*border, setup.body.surface.box, grid.h, grid.origin);
}

std::string span_of(const PlacedBox& box) {
  const Vec3 lower = plus(box.lower, box.origin), upper = plus(box.upper, box.origin);
  return fmt::format("{:.4g}..{:.4g}, {:.4g}..{:.4g}, {:.4g}..{:.4g} m", lower[0], upper[0],
                     lower[1], upper[1], lower[2], upper[2]);
}

Holder holder_of(const Move& move, const PlacedBox& box) {
  Holder holder;
  holder.turns = move.turns;
  holder.path = move.path;
  for (size_t d = 0; d < 3 && move.turns; ++d)
    holder.centre[d] = coordinate(move.turn_centre[d], int(d), box);
  return holder;
}

void add_borders(const RunDescription& run, const PlacedBox& box, VoxelizeOptions& options) {
  if (!holder_of_nodes(run).empty()) return;
  for (const HeldPart& part : held_parts(run, box))
    if (const auto border = border_of(*part.selection, box)) options.borders.push_back(*border);
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
  scene.holder = Array<int32_t>(scene.grid.node_count());
  std::fill_n(scene.holder.data(), scene.holder.rows(), -1);
  std::vector<int32_t> holder_of_border(borders.size(), -1);
  // parts that the grid fits by their nodes, the others at their borders
  const std::vector<HeldPart> parts = held_parts(run, box);
  check_apart(parts, setup);
  for (const HeldPart& part : parts) {
    const auto holder = int32_t(scene.holders.size());
    scene.holders.push_back(part.holder);
    const std::optional<Border> border = border_of(*part.selection, box);
    if (borders.empty() || fits_grid(border, setup)) {
      pin_nodes(part, holder, borders.empty() ? std::nullopt : border, setup.tets.has_value(),
                setup);
      continue;
    }
    const auto number = std::ranges::find(borders, *border) - borders.begin();
    claim_border(holder, holder_of_border[size_t(number)], scene);
    if (std::ranges::any_of(cut, [&](const BorderVoxel& at) { return at.border == number; }))
      setup.borders.push_back({*border, holder});
    else
      setup.warnings.push_back(
          fmt::format("{} holds nothing: nothing of the asset lies in it, or nothing beside it is "
                      "free; the asset spans {}",
                      part.option, span_of(box)));
  }
  add_dependent(borders, cut, holder_of_border, scene);
  say_coarse(setup.borders, setup);
  if (!holder_of_nodes(run).empty()) say_nodes_hold(run, setup);
}

std::vector<HeldPoint> points_behind(const std::vector<HeldBorder>& borders, const PlacedBox& box,
                                     In<double> points) {
  std::vector<HeldPoint> held;
  const double margin = kOnBorder * longest_extent(box);
  for (int64_t p = 0; p < points.rows && !borders.empty(); ++p)
    for (const auto& [border, holder] : borders)
      if (distance(border, {points(p, 0), points(p, 1), points(p, 2)}) <= margin) {
        held.push_back({p, holder});
        break;
      }
  return held;
}

std::vector<HeldPoint> rest_behind(const std::vector<HeldBorder>& borders, const PlacedBox& box,
                                   In<double> points, Array<double>& weights) {
  std::vector<HeldPoint> held = points_behind(borders, box, points);
  for (const HeldPoint& point : held) std::fill_n(weights.row(point.point), 8, 0.0);
  return held;
}

}  // namespace elastogen
