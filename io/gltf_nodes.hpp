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
/// @throws Error (asset) on an invalid transform, a mesh or child that does not exist, two
///         parents, a cycle.
std::vector<AssetNode> gltf_nodes(const std::string& path, const tinygltf::Model& model);

/// Roots of the default scene, else of the first scene; without scenes all roots.
/// @param model  has been checked by gltf_nodes; so for the functions below.
/// @throws Error (asset) on a scene or a node that does not exist.
std::vector<int> gltf_scene_roots(const std::string& path, const tinygltf::Model& model);

/// The nodes of the scene that gltf_scene_roots chooses.
/// @throws Error (asset) as gltf_scene_roots, and on a node that is listed twice.
std::vector<int> gltf_scene_nodes(const std::string& path, const tinygltf::Model& model);

}  // namespace elastogen
