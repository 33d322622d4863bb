// SPDX-License-Identifier: Apache-2.0
// Dependent nodes of tetrahedra that borders cut, as those of voxels (voxelize/dependent_nodes.hpp):
//
//     a_i = sum_m alpha_m a_m,   a_m = u_m/d_m at free nodes,   u_i = d_i a_i,
//
// m the nodes ahead of i along the gradient n of the distance that share an element with it, and
//
//     alpha = argmin |sum_m alpha_m t_m|^2 + epsilon sum_m (h alpha_m/d_m)^2,   sum alpha = 1, alpha >= 0,
//
// t_m the part of x_m - x_i across n over h: slopes are carried along n, from afar rather than from
// nodes close to the border. Of quadratic elements t_m has 1e-3 of the part along n too, and alpha may be
// negative: slopes may change along n, as far as that takes no large factors.

#pragma once

#include "core/dependent_nodes.hpp"
#include "mpm_fem/fem/cut_tets.hpp"

namespace elastogen::fem {

/// The nodes of cut elements, middles of edges too, are dependent where they lie nearer to the border
/// than nearest_free() spacings of the nodes there, or behind it. A node belongs to the nearest border.
/// Distances from curved borders are levelled.
/// @param mesh     of cut_tets(), as is `cut`.
/// @param pinned   nodes that are held already, (nodes, 1).
/// @param borders_of_nodes  gets the number of the border that each dependent node belongs to.
DependentNodes dependent_tet_nodes(const ElementMesh& mesh, const std::vector<Border>& borders,
                                   const std::vector<BorderElement>& cut,
                                   const Array<uint8_t>& pinned,
                                   std::vector<int32_t>* borders_of_nodes = nullptr);

}  // namespace elastogen::fem
