// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/picture_options.hpp"

#include "core/error.hpp"
#include "io/byte_reader.hpp"
#include "io/frame_files.hpp"
#include "io/safe_file.hpp"
#include "io/scene_keys.hpp"

namespace elastogen {
namespace {

constexpr std::string_view kNames[] = {"three-quarter", "front", "back",     "left",
                                       "right",         "top",   "turntable"};

}  // namespace

std::span<const std::string_view> view_names() {
  return kNames;
}

View view_from_name(std::string_view name) {
  std::string known;
  size_t nearest = 0;
  for (size_t k = 0; k < std::size(kNames); ++k) {
    if (kNames[k] == name) return View(k);
    if (edit_distance(name, kNames[k]) < edit_distance(name, kNames[nearest])) nearest = k;
    known += concat(k > 0 ? ", " : "", kNames[k]);
  }
  throw Error(
      concat("--camera '", name, "': known are ", known, "; did you mean ", kNames[nearest], '?'));
}

void set_image_size(const std::string& text, PictureOptions& options) {
  options.width = options.height = 0;
  if (text == "auto") return;
  const size_t times = text.find('x');
  const auto edge = [&](const std::string& digits) {
    const auto value = to_integer(digits);
    return value && *value >= kLeastPicture && *value <= kLargestPicture ? int(*value) : 0;
  };
  options.width = edge(text.substr(0, times));
  options.height = times < text.size() ? edge(text.substr(times + 1)) : 0;
  ELASTOGEN_CHECK(options.width > 0 && options.height > 0, "--image-size '", text,
                  "': expected auto or WIDTHxHEIGHT of one picture, ", kLeastPicture, " to ",
                  kLargestPicture, " pixels each, like 960x540");
}

void check_pictures(const std::vector<std::string>& outputs, const PictureOptions& options) {
  const int64_t pixels = int64_t(options.width) * options.height;
  for (const std::string& path : outputs)
    if (ending_of(path) == "png")
      ELASTOGEN_CHECK(!frame_file(path, 0).empty() || pixels <= kLargestTile, path,
                      ": a picture of a sheet has at most ", kLargestTile, " pixels, got ",
                      options.width, 'x', options.height, "; NAME_%04d.png writes one a frame");
}

}  // namespace elastogen
