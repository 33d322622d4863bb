// SPDX-License-Identifier: Apache-2.0
// Repairs normals of a glTF document that are not of length one.

#pragma once

#include "io/finding.hpp"
#include "io/gltf_edit.hpp"

namespace elastogen {

/// Gives the normals of triangles the length one, for the solver and for the output. A normal of
/// length zero becomes that of the faces around it, or (0, 0, 1). Primitives whose normals are off
/// by at most 5e-4 stay as they are; errors up to 1e-2, as packed normals have, are not counted.
/// @throws Error (asset) naming the primitive whose normals do not fit its positions.
void mend_gltf_normals(GltfEdit& edit, std::vector<Finding>& findings);

}  // namespace elastogen
