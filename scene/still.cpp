// SPDX-License-Identifier: Apache-2.0
#include "scene/still.hpp"

#include "io/animation_writer.hpp"
#include "io/safe_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kTrace = 1e-6;  // share of the longest edge; no file shows less motion

/// 1 for nodes that cannot move along an axis: pinned, or held along it.
Array<uint8_t> held_along(const Setup& setup, const RunDescription& run, int axis) {
  const Scene& scene = setup.scene;
  Array<uint8_t> held = scene.pinned;
  for (const Hold& hold : run.holds) {
    if (!hold.axes[size_t(axis)]) continue;
    const Array<uint8_t> selected = selected_nodes(setup, hold.selection);
    for (int64_t n = 0; n < held.rows(); ++n) held(n) |= selected(n);
  }
  return held;
}

/// Height of the body along the pull [m], and whether all its lowest nodes are held.
struct Underside {
  double height = 0;
  bool held = true;
};

Underside underside(const Setup& setup, const Array<uint8_t>& held, int axis, double sign) {
  const VoxelGrid& grid = setup.scene.grid;
  double lowest = -1e300, highest = 1e300;  // along the pull
  for (int64_t n = 0; n < grid.node_count(); ++n) {
    lowest = std::max(lowest, sign * grid.rest(n, axis));
    highest = std::min(highest, sign * grid.rest(n, axis));
  }
  Underside result{lowest - highest};
  for (int64_t n = 0; n < grid.node_count(); ++n)
    if (sign * grid.rest(n, axis) > lowest - grid.h / 2) result.held &= held(n) != 0;
  return result;
}

/// Whether all points of the asset lie behind borders.
bool all_points_held(const Setup& setup) {
  const Array<double>& points = setup.body.carried;
  const double margin = 1e-9 * setup.longest_edge;
  for (int64_t p = 0; p < points.rows(); ++p)
    if (std::ranges::none_of(setup.borders, [&](const HeldBorder& held) {
          return distance(held.border, {points(p, 0), points(p, 1), points(p, 2)}) <= margin;
        }))
      return false;
  return points.rows() > 0;
}

std::string cause_of(const Setup& setup, const RunDescription& run) {
  const Scene& scene = setup.scene;
  // nothing can move
  const auto all = [](const Array<uint8_t>& held) {
    return std::all_of(held.data(), held.data() + held.rows(), [](uint8_t h) { return h != 0; });
  };
  if (all(scene.pinned)) return "every node is pinned";
  if (all_points_held(setup))
    return "all points of the asset lie in what is held; a finer mesh would show what is between";
  // loads of the user
  if (!run.tractions.empty() || !run.forces.empty() || !run.wind.keys.empty() || !run.moves.empty())
    return "loads and moves are too small to show";
  // gravity: absent, or along an axis that is held
  const Vec3& pull = scene.gravity;
  if (pull == Vec3{}) return "there is no gravity and no start motion";
  const auto size = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const int axis = int(std::max_element(pull.begin(), pull.end(), size) - pull.begin());
  const Array<uint8_t> held = held_along(setup, run, axis);
  if (all(held))
    return fmt::format("gravity pulls along {}, along which every node is held", "xyz"[axis]);
  // the own weight, which shortens a column by rho g H^2 / (2 E)
  const double g = std::abs(pull[size_t(axis)]);
  const Underside below = underside(setup, held, axis, pull[size_t(axis)] > 0 ? 1 : -1);
  const Material& material = scene.materials[0];
  const double pressed = material.density * g * below.height * below.height / (2 * material.young);
  if (below.held)
    return fmt::format(
        "its whole underside is held, so that its weight only presses it together, by about "
        "{:.2g} m",
        pressed);
  if (!scene.colliders.empty())
    return fmt::format(
        "it stands where it is from the start, and its weight presses it together by about "
        "{:.2g} m only",
        pressed);
  return fmt::format("the material ({:.3g} Pa) is too stiff for its weight to show",
                     material.young);
}

}  // namespace

std::string said_of_stillness(const Setup& setup, const RunDescription& run, double motion) {
  const double share = motion / setup.longest_edge;
  const bool shown = std::ranges::any_of(
      run.outputs, [](const std::string& path) { return ending_of(path) == "glb"; });
  if (share >= (shown ? kVisibleMotion : kTrace)) return "";
  if (share < kTrace) return "nothing moved: " + cause_of(setup, run);
  return fmt::format("hardly anything moved, {:.2g} m at most, {:.2g} of the longest edge: {}",
                     motion, share, cause_of(setup, run));
}

}  // namespace elastogen
