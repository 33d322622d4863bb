// SPDX-License-Identifier: Apache-2.0
// What borders leave free of tetrahedra (docs/physics.md, section 3a).

#pragma once

#include "mpm_fem/fem/element_mesh.hpp"
#include "voxelize/border.hpp"

#include <vector>

namespace elastogen::fem {

/// An element of which a border holds a part.
struct BorderElement {
  int32_t element, border;
};

struct CutTets {
  ElementMesh mesh;                ///< the elements with a free part, on all nodes
  std::vector<int64_t> number;     ///< that of each in the whole mesh
  std::vector<BorderElement> cut;  ///< of them those that borders cut
};

/// Distances [longest extents of the mesh] below which a node lies on a border.
inline constexpr double kNodeOnBorder = 1e-9;

/// Tetrahedra that lie behind a border leave the mesh. Of those that one cuts `fill` gets the factor
/// of the free share, and `part` the affine map to the tetrahedron of the same centroid and second
/// moments: for tet10 as good as Gauss points within the free part, of degree 2. The free part is
/// that of the tetrahedron of the corners. What planes leave is exact. Of balls and boxes it is that
/// of 512 small tetrahedra with their centroids outside, off by at most the share of those that the
/// border cuts.
/// @param borders  none: the mesh as it is, without numbers.
CutTets cut_tets(const ElementMesh& mesh, const std::vector<Border>& borders);

/// Whether a border cuts an element.
bool cuts(const ElementMesh& mesh, const Border& border);

}  // namespace elastogen::fem
