// SPDX-License-Identifier: Apache-2.0
// What may be said of pictures.

#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace elastogen {

/// Directions of --camera. Front is where +z points in an asset with y up, left and right are those
/// of the viewer there; the turntable begins as three-quarter and goes once around.
enum class View : uint8_t { kThreeQuarter, kFront, kBack, kLeft, kRight, kTop, kTurntable };

/// Names of the views, in their order.
std::span<const std::string_view> view_names();

/// @throws Error (usage) with the names and the one that is nearest.
View view_from_name(std::string_view name);

inline constexpr int kLeastPicture = 16, kLargestPicture = 4096;  ///< edges of a picture [pixels]
inline constexpr int64_t kLargestTile = int64_t{1} << 22;         ///< of a contact sheet [pixels]

/// How the pictures of a clip are taken.
struct PictureOptions {
  View view = View::kThreeQuarter;
  int width = 0, height = 0;  ///< of one picture [pixels]; 0: by what is written
};

/// Sets the size that "WIDTHxHEIGHT" or "auto" says. @throws Error (usage) with what is expected.
void set_image_size(const std::string& text, PictureOptions& options);

/// Names and sizes of the pictures among the outputs of a run.
/// @throws Error (usage) on a name as check_number, and on pictures too large for a sheet.
void check_pictures(const std::vector<std::string>& outputs, const PictureOptions& options);

}  // namespace elastogen
