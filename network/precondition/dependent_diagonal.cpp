// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/dependent_diagonal.hpp"

#include "network/precondition/multigrid_element.hpp"
#include "network/precondition/multigrid_grid.hpp"

#include <algorithm>
#include <map>

namespace elastogen {
namespace {

/// Values at the corners of a voxel where one free node moves by 1.
struct CornerValues {
  double of[8] = {};
};

/// The dependent node of each node, -1 if it is none.
std::vector<int64_t> dependent_places(const Scene& scene) {
  std::vector<int64_t> place(size_t(scene.grid.node_count()), -1);
  for (int64_t i = 0; i < scene.dependent.count(); ++i) place[size_t(scene.dependent.node(i))] = i;
  return place;
}

/// The free nodes that move the corners of a voxel, with these motions.
std::map<int32_t, CornerValues> columns_of(const Scene& scene, int64_t v,
                                           const std::vector<int64_t>& place) {
  std::map<int32_t, CornerValues> columns;
  for (int c = 0; c < 8; ++c) {
    const int32_t n = scene.grid.corners(v, c);
    const int64_t i = place[size_t(n)];
    if (i < 0) {
      if (!scene.pinned(n)) columns[n].of[c] += 1;
      continue;
    }
    const Span<const int32_t> parents = scene.dependent.parents(i);
    const Span<const double> weights = scene.dependent.weights(i);
    for (int64_t k = 0; k < parents.rows; ++k) columns[parents(k)].of[c] += weights(k);
  }
  return columns;
}

/// Adds what a voxel has more with dependent nodes than without.
void add_voxel(const Scene& scene, int64_t v, const std::vector<int64_t>& place,
               std::vector<double>& more) {
  double k[6], M[7], force[8];
  moduli_of_voxel(scene, v, k);
  hex8::fill_moments(scene.grid.shape_mean.row(v), M);
  for (double& modulus : k) modulus *= scene.grid.h;
  for (const auto& [node, column] : columns_of(scene, v, place)) {
    CornerValues own;
    for (int c = 0; c < 8; ++c) own.of[c] = scene.grid.corners(v, c) == node;
    for (int i = 0; i < 3; ++i) {
      double sum = 0;
      scalar_element<true>(k, M, i, column.of, force);
      for (int c = 0; c < 8; ++c) sum += column.of[c] * force[c];
      scalar_element<true>(k, M, i, own.of, force);
      for (int c = 0; c < 8; ++c) sum -= own.of[c] * force[c];
      more[size_t(3 * node + i)] += sum;
    }
  }
}

}  // namespace

std::vector<double> dependent_diagonal(const Scene& scene, double inertia) {
  if (scene.dependent.empty()) return {};
  const VoxelGrid& grid = scene.grid;
  const std::vector<int64_t> place = dependent_places(scene);
  std::vector<double> more(3 * size_t(grid.node_count()));
  // elastic terms of voxels with a dependent corner, then inertia
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    const int32_t* corners = grid.corners.row(v);
    if (std::any_of(corners, corners + 8, [&](int32_t n) { return place[size_t(n)] >= 0; }))
      add_voxel(scene, v, place, more);
  }
  for (int64_t i = 0; i < scene.dependent.count(); ++i) {
    const Span<const int32_t> parents = scene.dependent.parents(i);
    const Span<const double> weights = scene.dependent.weights(i);
    const double m = inertia * scene.mass(scene.dependent.node(i));
    for (int64_t k = 0; k < parents.rows; ++k)
      for (int d = 0; d < 3; ++d) more[size_t(3 * parents(k) + d)] += weights(k) * weights(k) * m;
  }
  for (double& value : more) value = std::max(value, 0.0);
  return more;
}

}  // namespace elastogen
