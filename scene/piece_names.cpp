// SPDX-License-Identifier: Apache-2.0
#include "scene/piece_names.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace elastogen {
namespace {

constexpr size_t kShown = 3;  // pairs

/// Rounds down to two digits.
double rounded_down(double x) {
  const double step = std::pow(10, std::floor(std::log10(x)) - 1);
  return std::floor(x / step) * step;
}

}  // namespace

std::string name_at(const Asset& asset, const Surface& surface, int64_t triangle) {
  for (const SurfaceInstance& instance : surface.instances) {
    if (triangle < instance.first_triangle ||
        triangle >= instance.first_triangle + instance.triangles)
      continue;
    const std::string& name = asset.nodes[size_t(instance.node)].name;
    return name.empty() ? asset.meshes[size_t(instance.mesh)].name : name;
  }
  return "";
}

void add_joined_pieces(const Asset& asset, const Surface& surface, std::span<const PieceGap> gaps,
                       std::vector<Finding>& findings) {
  if (gaps.empty()) return;
  std::vector<PieceGap> nearest(gaps.begin(), gaps.end());
  std::ranges::stable_sort(nearest, {}, &PieceGap::distance);
  std::string text = "pairs of pieces are nearer than voxels can tell:";
  for (size_t k = 0; k < std::min(kShown, nearest.size()); ++k) {
    std::string name[2];
    for (size_t i = 0; i < 2; ++i) name[i] = name_at(asset, surface, nearest[k].triangle[i]);
    const std::string pair = name[0] != name[1] ? fmt::format("'{}' and '{}'", name[0], name[1])
                             : name[0].empty()  ? "two"
                                                : fmt::format("two of '{}'", name[0]);
    text += fmt::format("{} {} ({:.2g} m)", k > 0 ? "," : "", pair, nearest[k].distance);
  }
  if (nearest.size() > kShown) text += fmt::format(" and {} more", nearest.size() - kShown);
  text += fmt::format("; voxels of {:.2g} m would part them",
                      rounded_down(nearest[0].distance / (2 * std::sqrt(3.0))));
  findings.push_back({"joined-pieces", int64_t(nearest.size()), text});
}

}  // namespace elastogen
