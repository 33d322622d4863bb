// SPDX-License-Identifier: Apache-2.0
// Pictures of an animation, drawn when all its frames are known: no graphics library, no window.

#pragma once

#include "cli/picture/scene_picture.hpp"
#include "io/animation_writer.hpp"
#include "scene/set_up.hpp"

namespace elastogen {

/// A writer of NAME.png: up to 12 frames evenly spaced from the first to the last on one sheet, or
/// one picture a frame if the name has a number (io/frame_files.hpp). Frames wait in unnamed files
/// beside the output, in single precision.
/// @param notes  gets a sentence for each texture that cannot be shown.
/// @param options  must have passed check_pictures.
/// @throws Error (usage) from finish without a frame; (resources) if the folder cannot be written.
/// Asset and setup must outlive the writer.
std::unique_ptr<AnimationWriter> make_picture_writer(const std::string& path, const Asset& asset,
                                                     const Setup& setup, double fps,
                                                     const PictureOptions& options,
                                                     std::vector<std::string>& notes);

}  // namespace elastogen
