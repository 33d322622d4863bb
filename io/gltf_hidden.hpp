// SPDX-License-Identifier: Apache-2.0
// Nodes of a glTF document that nobody sees: they are not simulated.

#pragma once

#include "io/asset.hpp"
#include "io/gltf_edit.hpp"

#include <string>
#include <vector>

namespace tinygltf {
class Model;
}

namespace elastogen {

/// 1 for each node that KHR_node_visibility hides, or one above it.
/// @param nodes  of the document; it has passed check_gltf_types.
/// @throws Error (asset) naming the node whose `visible` is no truth value.
std::vector<char> invisible_nodes(const std::string& path, const GltfEdit::Json& nodes);

/// The same, and nodes that are scaled to a plane, a line or a point. The scale of a node with a
/// skin has no part in what it shows.
/// @throws Error (asset) also as gltf_nodes.
std::vector<char> hidden_nodes(const std::string& path, const GltfEdit::Json& nodes,
                               const tinygltf::Model& model);

/// Whether the linear part of a matrix has no inverse to the rounding of float32.
bool is_singular(const Matrix4& matrix);

/// The first names, for people: "A, B and 3 more"; nodes without one by their index.
std::string node_names(const std::vector<AssetNode>& nodes, const std::vector<int>& some);

}  // namespace elastogen
