// SPDX-License-Identifier: Apache-2.0
// Nodes of a glTF document that nobody sees. They are not simulated.

#pragma once

#include "io/asset.hpp"
#include "io/gltf_edit.hpp"

#include <string>
#include <vector>

namespace tinygltf {
class Model;
}

namespace elastogen {

/// 1 for each node that KHR_node_visibility hides, itself or through a node above it.
/// @param nodes  nodes of the document, which has passed check_gltf_types.
/// @throws Error (asset) naming the node whose `visible` is no truth value.
std::vector<char> invisible_nodes(const std::string& path, const GltfEdit::Json& nodes);

/// 1 for each invisible node and for each node scaled to a plane, a line or a point. The scale of a
/// node with a skin does not matter, as it has no part in what the node shows.
/// @throws Error (asset) as invisible_nodes and as gltf_nodes.
std::vector<char> hidden_nodes(const std::string& path, const GltfEdit::Json& nodes,
                               const tinygltf::Model& model);

/// Whether the linear part of a matrix has no inverse, up to the rounding of float32.
bool is_singular(const Matrix4& matrix);

/// The first names for a message: "A, B and 3 more"; nodes without a name by their index.
std::string node_names(const std::vector<AssetNode>& nodes, const std::vector<int>& some);

}  // namespace elastogen
