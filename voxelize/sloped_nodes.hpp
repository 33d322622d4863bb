// SPDX-License-Identifier: Apache-2.0
// Dependent nodes by their slopes a_i, which are carried from the farthest nodes on towards a border
// (voxelize/dependent_nodes.hpp): u_i = d_i a_i.

#pragma once

#include "core/dependent_nodes.hpp"

#include <algorithm>
#include <map>
#include <utility>
#include <vector>

namespace elastogen {

/// A dependent node and, once it is known, its slope a = sum of factor u_m over free nodes m.
struct SlopedNode {
  int32_t border = -1;
  double distance = 0;  ///< from the border, positive outside
  bool known = false;
  std::map<int32_t, double> slope;
};
using SlopedNodes = std::map<int32_t, SlopedNode>;

/// Lets the nearest border have a node.
inline void offer(SlopedNodes& nodes, int32_t node, int32_t border, double distance) {
  SlopedNode& of = nodes[node];
  if (of.border < 0 || distance < of.distance) of.border = border, of.distance = distance;
}

/// The border of each node, in their order.
inline std::vector<int32_t> borders_of(const SlopedNodes& nodes) {
  std::vector<int32_t> result;
  for (const auto& [node, of] : nodes) result.push_back(of.border);
  return result;
}

/// Finds the slopes by find_slope(node, SlopedNode&), from the farthest nodes on, those of one
/// distance by their numbers, and makes weights of them.
template <class FindSlope>
DependentNodes follow_slopes(SlopedNodes& sloped, const FindSlope& find_slope) {
  std::vector<std::pair<double, int32_t>> order;
  for (const auto& [node, of] : sloped) order.push_back({-of.distance, node});
  std::ranges::sort(order);
  for (const auto& [key, node] : order) find_slope(node, sloped.at(node));
  // weights
  std::vector<int32_t> nodes, begin = {0}, parents;
  std::vector<double> weights;
  for (const auto& [node, of] : sloped) {
    nodes.push_back(node);
    for (const auto& [parent, factor] : of.slope)
      if (of.distance * factor != 0)
        parents.push_back(parent), weights.push_back(of.distance * factor);
    begin.push_back(int32_t(parents.size()));
  }
  return {std::move(nodes), std::move(begin), std::move(parents), std::move(weights)};
}

}  // namespace elastogen
