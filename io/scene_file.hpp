// SPDX-License-Identifier: Apache-2.0
// Scene files (docs/scene.md): checked against the table of io/scene_keys.hpp, in SI.

#pragma once

#include "io/scene_value.hpp"

namespace elastogen {

/// Reads a scene from a .toml or .json file. Every number comes back in SI, asset.file from the
/// scene file's folder.
/// @throws Error (usage) with file, line and key: everything that parse_scene refuses; an unknown
///         key (naming the nearest); another type, word, unit or range than the key has; a collider
///         that lacks a key of its shape or has one of another; a pin, region, hold, traction or
///         move without exactly one of select, node and gltf_material, or that lacks a key; a file
///         that cannot be read.
SceneValue read_scene(const std::string& path);

/// Checks a scene in a text. @param name  of the file, for messages and relative paths.
SceneValue check_scene(std::string_view text, const std::string& name);

/// A scene as indented JSON text, with its keys in order.
std::string scene_json(const SceneValue& scene);

}  // namespace elastogen
