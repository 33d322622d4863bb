// SPDX-License-Identifier: Apache-2.0
// What pins and moves hold of tetrahedra, of a file or cut from voxels: nodes where the mesh fits their
// borders, else the body at the border (mpm_fem/fem/{cut_tets,dependent_tet_nodes}).

#pragma once

#include "scene/set_up.hpp"

namespace elastogen {

/// Cuts the tetrahedra of a setup that has materials, pinned nodes and the points that meet colliders
/// at borders that their mesh does not fit. Those of a voxel share what is free of it, as the grid has
/// it. Does nothing to other elements. Warns of pins and moves that hold nothing of a file's.
void hold_tets(const RunDescription& run, Setup& setup);

}  // namespace elastogen
