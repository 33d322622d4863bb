// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/held_diagonal.hpp"

#include "core/parallel.hpp"
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

/// The three scalar operators of a voxel.
class Voxel {
 public:
  Voxel(const Scene& scene, int64_t v) {
    moduli_of_voxel(scene, v, k_);
    hex8::fill_moments(scene.grid.shape_mean.row(v), M_);
    for (double& modulus : k_) modulus *= scene.grid.h;
  }
  /// a^T A_i a.
  double quadratic(int i, const CornerValues& a) const {
    double force[8], sum = 0;
    scalar_element<true>(k_, M_, i, a.of, force);
    for (int c = 0; c < 8; ++c) sum += a.of[c] * force[c];
    return sum;
  }

 private:
  double k_[6], M_[7];
};

/// Adds what a voxel has more with dependent nodes than without.
void add_voxel(const Scene& scene, int64_t v, const std::vector<int64_t>& place,
               std::vector<double>& more) {
  const Voxel voxel(scene, v);
  for (const auto& [node, column] : columns_of(scene, v, place)) {
    CornerValues own;
    for (int c = 0; c < 8; ++c) own.of[c] = scene.grid.corners(v, c) == node;
    for (int i = 0; i < 3; ++i) {
      double& sum = more[size_t(3 * node + i)];
      sum += voxel.quadratic(i, column) - voxel.quadratic(i, own);
    }
  }
}

/// Adds the stiffness of fixed components.
void add_fixed(const Scene& scene, double inertia, std::vector<double>& more) {
  for_each(scene.fixed.rows(), [&](int64_t n) {
    for (int i = 0; i < 3; ++i) {
      if (scene.fixed(n, i) < 0) continue;
      double sum = inertia * scene.mass(n);
      for (int c = 0; c < 8; ++c) {
        const int32_t v = scene.grid.voxels(n, c);
        if (v < 0) continue;
        CornerValues own;
        for (int k = 0; k < 8; ++k) own.of[k] = scene.grid.corners(v, k) == n;
        sum += Voxel(scene, v).quadratic(i, own);
      }
      more[size_t(3 * n + i)] += kHoldStiffness * sum;
    }
  });
}

}  // namespace

std::vector<double> held_diagonal(const Scene& scene, double inertia) {
  if (scene.dependent.empty() && scene.fixed.empty()) return {};
  const VoxelGrid& grid = scene.grid;
  const std::vector<int64_t> place = dependent_places(scene);
  std::vector<double> more(3 * size_t(grid.node_count()));
  // elastic terms of voxels with a dependent corner, inertia, then what is fixed
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
  add_fixed(scene, inertia, more);
  return more;
}

}  // namespace elastogen
