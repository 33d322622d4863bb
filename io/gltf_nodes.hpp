// SPDX-License-Identifier: Apache-2.0
// The node tree of a glTF document.

#pragma once

#include "io/asset.hpp"

#include <string>
#include <vector>

namespace tinygltf {
class Model;
}

namespace elastogen {

/// All nodes with name, parent and matrix, in file order; none shows a mesh yet.
/// @throws Error (asset) on a transform that is none, a mesh or child that does not exist, two
///         parents, a cycle.
std::vector<AssetNode> gltf_nodes(const std::string& path, const tinygltf::Model& model);

/// Roots of the default scene; of the first where none is named; all roots without scenes.
/// @param model  as gltf_nodes has checked it; the same below.
/// @throws Error (asset) on a scene or a node that does not exist.
std::vector<int> gltf_scene_roots(const std::string& path, const tinygltf::Model& model);

/// The nodes of that scene.
/// @throws Error (asset) also on a node that is listed twice.
std::vector<int> gltf_scene_nodes(const std::string& path, const tinygltf::Model& model);

}  // namespace elastogen
