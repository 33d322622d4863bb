// SPDX-License-Identifier: Apache-2.0
// Reads TOML (toml.io, 1.0) and JSON (RFC 8259) into one kind of tree. The text is not trusted.

#pragma once

#include "io/scene_value.hpp"

#include <cstdint>

namespace elastogen {

inline constexpr int kMaxSceneDepth = 64;
inline constexpr int64_t kMaxSceneBytes = 16'000'000;
/// Lower limits for TOML: its parser needs seconds for a MiB, and time quadratic in a line's
/// length.
inline constexpr int64_t kMaxTomlBytes = 1 << 20, kMaxTomlLine = 2048;

/// Parses a scene.
/// @param name  of the file, for messages; .json and .toml decide the format, else the first
///              character does ('{' is JSON).
/// @throws Error (usage) with name and line: text that is no TOML or JSON, a key that occurs twice,
///         a number that is not finite, null, dates and times, more than kMaxSceneDepth levels,
///         texts above kMaxSceneBytes (TOML: kMaxTomlBytes, lines of kMaxTomlLine).
SceneValue parse_scene(std::string_view text, const std::string& name);

}  // namespace elastogen
