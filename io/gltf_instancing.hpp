// SPDX-License-Identifier: Apache-2.0
// EXT_mesh_gpu_instancing: one node that shows its mesh at many places.

#pragma once

#include "io/asset.hpp"
#include "io/gltf_edit.hpp"

#include <vector>

namespace elastogen {

/// Gives a node with instances a child for each, NAME_instance_1, ..., with the node's mesh and the
/// instance's TRANSLATION, ROTATION and SCALE. Other attributes are left out with a finding.
/// @throws Error (asset) naming the node and attribute: no attributes, counts that differ, numbers
///         that are not finite, a rotation of no length, an accessor out of range, a skin, more
///         than a million nodes.
void expand_instances(GltfEdit& edit, std::vector<Finding>& findings);

}  // namespace elastogen
