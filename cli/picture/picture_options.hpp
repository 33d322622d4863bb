// SPDX-License-Identifier: Apache-2.0
// Options of pictures.

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

/// Directions of --camera. An asset with y up has its front towards +z; left and right are those of
/// the viewer there. The turntable starts as three-quarter and turns once around.
enum class View : uint8_t { kThreeQuarter, kFront, kBack, kLeft, kRight, kTop, kTurntable };

/// Names of the views, in their order.
std::span<const std::string_view> view_names();

/// @throws Error (usage) with all names and the nearest one.
View view_from_name(std::string_view name);

inline constexpr int kLeastPicture = 16, kLargestPicture = 4096;  ///< edges of a picture [pixels]
inline constexpr int64_t kLargestTile = int64_t{1} << 22;  ///< picture on a contact sheet [pixels]

/// View and size of the pictures of a clip.
struct PictureOptions {
  View view = View::kThreeQuarter;
  int width = 0, height = 0;  ///< of one picture [pixels]; 0: chosen by the output
};

/// Sets the size from "WIDTHxHEIGHT" or "auto". @throws Error (usage) with what is expected.
void set_image_size(const std::string& text, PictureOptions& options);

/// Checks names and sizes of the pictures among the outputs of a run.
/// @throws Error (usage) on a name as check_number, and on pictures that are too large for a sheet.
void check_pictures(const std::vector<std::string>& outputs, const PictureOptions& options);

}  // namespace elastogen
