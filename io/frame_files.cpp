// SPDX-License-Identifier: Apache-2.0
#include "io/frame_files.hpp"

#include "core/error.hpp"
#include "io/byte_reader.hpp"
#include "io/safe_file.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>

namespace elastogen {

static_assert(std::endian::native == std::endian::little);

std::string frame_path(const std::string& path, int64_t frame, const std::string& ending) {
  const std::filesystem::path whole(path);
  std::string number = std::to_string(frame);
  number.insert(0, number.size() < 5 ? 5 - number.size() : 0, '0');
  return (whole.parent_path() / (whole.stem().string() + '_' + number + ending)).string();
}

std::string frame_ending(const std::string& path) {
  const std::string ending = ending_of(path);
  return ending == "ply" ? ".ply" : ending == "pvd" ? ".vtu" : "";
}

bool is_frame_of(const std::string& path, int64_t frames, const std::string& file) {
  const std::string ending = frame_ending(path);
  if (ending.empty()) return false;
  const std::string stem = std::filesystem::path(file).stem().string();
  const auto frame = to_integer(stem.substr(stem.rfind('_') + 1));
  return frame && *frame >= 0 && *frame <= frames && frame_path(path, *frame, ending) == file;
}

std::vector<Vec3> file_positions(const Asset& asset, const Surface& surface) {
  if (asset.points) return asset.points->position;
  if (asset.splats) return asset.splats->position;
  std::vector<Vec3> positions(size_t(surface.vertices.rows()));
  for (size_t v = 0; v < positions.size(); ++v)
    for (size_t d = 0; d < 3; ++d)
      positions[v][d] = surface.vertices(int64_t(v), int(d)) / surface.scale;
  return positions;
}

void check_frame(const AnimationFrame& frame, int64_t number, int64_t points, bool gradient) {
  const auto is_finite = [](const Span<const double>& values) {
    return std::all_of(values.data, values.data + values.size(),
                       [](double d) { return std::abs(d) < 1e38; });
  };
  ELASTOGEN_CHECK(frame.displacement.is(points, 3), "displacement must be (", points, ", 3), got ",
                  frame.displacement);
  ELASTOGEN_CHECK(is_finite(frame.displacement), "frame ", number,
                  " has a displacement that is not finite in single precision");
  if (!gradient) return;
  ELASTOGEN_CHECK(frame.gradient.is(points, 9), "gradient must be (", points, ", 9), got ",
                  frame.gradient);
  ELASTOGEN_CHECK(is_finite(frame.gradient), "frame ", number,
                  " has a gradient that is not finite in single precision");
}

}  // namespace elastogen
