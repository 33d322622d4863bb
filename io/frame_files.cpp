// SPDX-License-Identifier: Apache-2.0
#include "io/frame_files.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "io/byte_reader.hpp"
#include "io/safe_file.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <limits>
#include <numeric>

namespace elastogen {

static_assert(std::endian::native == std::endian::little);

namespace {

constexpr double kFloat32Share = 1e-5;  // of the longest edge

/// Endings of which every frame is a file of its own.
bool is_sequence(const std::string& ending) {
  return ending == "ply" || ending == "obj" || ending == "vdb";
}

/// The first %d or %0Nd of a name; begin is npos where there is none.
struct Number {
  size_t begin = std::string::npos, end = 0, digits = 1;
};

Number number_in(const std::string& path) {
  const auto at = [&](size_t k) { return k < path.size() ? path[k] : '\0'; };
  for (size_t k = path.find('%'); k < path.size(); k = path.find('%', k + 1)) {
    if (at(k + 1) == 'd') return {k, k + 2, 1};
    if (at(k + 1) == '0' && at(k + 2) >= '1' && at(k + 2) <= '9' && at(k + 3) == 'd')
      return {k, k + 4, size_t(at(k + 2) - '0')};
  }
  return {};
}

}  // namespace

std::string frame_path(const std::string& path, int64_t frame, const std::string& ending) {
  const std::filesystem::path whole(path);
  std::string number = std::to_string(frame);
  number.insert(0, number.size() < 5 ? 5 - number.size() : 0, '0');
  return (whole.parent_path() / (whole.stem().string() + '_' + number + ending)).string();
}

std::string frame_file(const std::string& path, int64_t frame) {
  const std::string ending = ending_of(path);
  if (is_sequence(ending)) return frame_path(path, frame, '.' + ending);
  if (ending == "pvd") return frame_path(path, frame, ".vtu");
  if (ending != "png") return "";
  check_number(path);
  const Number number = number_in(path);
  if (number.begin == path.npos) return "";
  std::string digits = std::to_string(frame);
  digits.insert(0, digits.size() < number.digits ? number.digits - digits.size() : 0, '0');
  return path.substr(0, number.begin) + digits + path.substr(number.end);
}

bool has_own_file(const std::string& path) {
  const std::string ending = ending_of(path);
  return !is_sequence(ending) && (ending != "png" || frame_file(path, 0).empty());
}

bool is_frame_of(const std::string& path, int64_t frames, const std::string& file) {
  if (frame_file(path, 0).empty()) return false;
  const Number number = number_in(path);
  std::string digits;
  if (ending_of(path) == "png") {
    const size_t behind = path.size() - number.end;
    if (file.size() <= number.begin + behind) return false;
    digits = file.substr(number.begin, file.size() - behind - number.begin);
  } else {
    const std::string stem = std::filesystem::path(file).stem().string();
    digits = stem.substr(stem.rfind('_') + 1);
  }
  const auto frame = to_integer(digits);
  return frame && *frame >= 0 && *frame <= frames && frame_file(path, *frame) == file;
}

void check_number(const std::string& path) {
  const size_t name = path.rfind('/') + 1;
  const Number number = number_in(path);
  const bool one = path.find('%') == number.begin && path.rfind('%') == number.begin;
  ELASTOGEN_CHECK(one && (number.begin == path.npos || number.begin >= name), path,
                  ": a % in the name of pictures is the number of the frame: once, in the name of "
                  "the file, as %d or %04d");
}

FileOrder file_order(const Asset& asset, const Surface& surface) {
  FileOrder order;
  // points and splats are their own vertices
  if (asset.points || asset.splats) {
    order.rest = asset.points ? asset.points->position : asset.splats->position;
    order.point.resize(order.rest.size());
    std::iota(order.point.begin(), order.point.end(), 0);
    order.vertex = order.point;
    return order;
  }
  // number of each carried point in the file; meshes may share a position
  for (const SurfaceInstance& instance : surface.instances) {
    const Mesh& mesh = asset.meshes[size_t(instance.mesh)];
    for (size_t i = 0; i < mesh.position.size(); ++i) {
      const bool own = !mesh.file_position.empty();
      order.vertex.push_back(own ? mesh.file_position[i]
                                 : int32_t(instance.first_vertex) + int32_t(i));
    }
  }
  // the first carried point of each vertex of the file
  const auto last = std::ranges::max_element(order.vertex);
  order.point.assign(last == order.vertex.end() ? 0 : size_t(*last) + 1, -1);
  for (size_t k = 0; k < order.vertex.size(); ++k) {
    int32_t& point = order.point[size_t(order.vertex[k])];
    if (point < 0) point = int32_t(k);
  }
  // rest positions of these, back in the numbers of the file
  for (const int32_t v : order.point) {
    const double* x = surface.vertices.row(v);
    order.rest.push_back(scaled(plus({x[0], x[1], x[2]}, surface.box.origin), 1 / surface.scale));
  }
  return order;
}

double float32_step(const std::vector<Vec3>& positions) {
  double largest = 0;
  for (const Vec3& x : positions)
    for (const double c : x) largest = std::max(largest, std::abs(c));
  if (largest > double(std::numeric_limits<float>::max())) return INFINITY;
  return double(std::nextafter(float(largest), INFINITY)) - double(float(largest));
}

bool is_float32_coarse(const std::vector<Vec3>& positions) {
  Box box;
  for (const Vec3& x : positions) box.add(x);
  const double longest = std::max({box.extent(0), box.extent(1), box.extent(2)});
  return !positions.empty() && float32_step(positions) > kFloat32Share * longest;
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
