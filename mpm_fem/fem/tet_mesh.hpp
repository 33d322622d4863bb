// SPDX-License-Identifier: Apache-2.0
// The tetrahedra or plane triangles of a file as finite elements.

#pragma once

#include "io/tets/tet_reader.hpp"
#include "mpm_fem/fem/element_mesh.hpp"

namespace elastogen::fem {

/// Moves nodes and elements out of a file; its regions and findings stay.
/// @return kTet4, kTet10 or kTri3, all of material 0.
ElementMesh take_mesh(tets::TetFile& file);

}  // namespace elastogen::fem
