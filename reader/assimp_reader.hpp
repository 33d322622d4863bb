// SPDX-License-Identifier: Apache-2.0
// Reads mesh files through assimp: the node tree, meshes and materials as in the file.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// Reads a file with the one importer of that format ("fbx", "dae", "3ds", "x", "ac"). Nothing
/// beside the file is opened, no post-processing is done, io/polygon.hpp turns polygons into
/// triangles. Textures keep their names. Left out with a finding: skins (the mesh stays in its bind
/// pose), morph targets, animations, embedded textures, points and lines.
///
/// Axes and units: assimp turns DAE to y up and metres, and 3DS to y up. FBX keeps its axes and
/// states them. X and AC have y up. All but DAE and FBX leave the unit open.
/// @throws Error (asset) with assimp's reason; std::bad_alloc at the memory limit.
Asset read_assimp(const std::string& path, const std::string& format);

}  // namespace elastogen
