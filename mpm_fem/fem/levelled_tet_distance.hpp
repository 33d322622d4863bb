// SPDX-License-Identifier: Apache-2.0
// Distances of nodes of linear tetrahedra from a border, levelled as those of voxels
// (voxelize/levelled_distance.hpp). Quadratic ones interpolate the distance well enough.

#pragma once

#include "mpm_fem/fem/cut_tets.hpp"

#include <map>

namespace elastogen::fem {

class LevelledTetDistance {
 public:
  /// d - e: e_v the mean of the interpolant of d over the border within each of the elements, e_i its
  /// mean over the elements of a node, weighted with the border's area, spread to a further ring of
  /// nodes by means. e is 0 for planes.
  LevelledTetDistance(const ElementMesh& mesh, const Border& border,
                      const std::vector<int32_t>& elements);

  double operator()(int32_t node) const;

 private:
  Vec3 rest(int32_t node) const;
  double mean_on_border(int32_t element, double& area) const;

  const ElementMesh& mesh_;
  const Border& border_;
  std::map<int32_t, double> excess_;  // e, by node
};

}  // namespace elastogen::fem
