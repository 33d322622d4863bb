// SPDX-License-Identifier: Apache-2.0
// Mesh files through assimp: the tree, meshes and materials as the file has them.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// Reads a file with the one importer of that format ("fbx", "dae", "3ds", "x", "ac"); nothing
/// beside the file is opened, no post-processing is done, polygons become triangles by
/// io/polygon.hpp. Textures are named as in the file. Left out with a finding: skins (the mesh
/// stays in its bind pose), morph targets, animations, embedded textures, points and lines.
///
/// Axes and units: assimp turns DAE to y up and metres and 3DS to y up; FBX keeps its axes and
/// states them; X and AC are y up. All but DAE and FBX leave the unit open.
/// @throws Error (asset) with assimp's reason; std::bad_alloc at the limit of memory.
Asset read_assimp(const std::string& path, const std::string& format);

}  // namespace elastogen
