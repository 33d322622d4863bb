// SPDX-License-Identifier: Apache-2.0
// Normals of a glTF document that are none.

#pragma once

#include "io/finding.hpp"
#include "io/gltf_edit.hpp"

namespace elastogen {

/// Gives the normals of triangles the length one, for the solver and for the output. One of length
/// zero is that of the faces around it, or (0, 0, 1). Primitives whose normals are off by 5e-4 at
/// most stay as they are; what is off by 1e-2 at most, as packed normals are, is not counted.
/// @throws Error (asset) naming the primitive whose normals do not fit its positions.
void mend_gltf_normals(GltfEdit& edit, std::vector<Finding>& findings);

}  // namespace elastogen
