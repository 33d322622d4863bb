// SPDX-License-Identifier: Apache-2.0
#include "cli/collider_option.hpp"

#include "core/error.hpp"
#include "io/units.hpp"
#include "voxelize/regions.hpp"

#include <cmath>
#include <sstream>
#include <vector>

namespace elastogen {
namespace {

using Shape = Collider::Shape;

using Texts = std::vector<std::string_view>;

Vec3 parse_point(const Texts& numbers, size_t first, const PlacedBox& box) {
  Vec3 point;
  for (size_t d = 0; d < 3; ++d)
    point[d] = coordinate(parse_place(numbers[first + d]), int(d), box);
  return point;
}

void parse_plane(const Texts& numbers, const PlacedBox& box, Collider& c) {
  c.centre = parse_point(numbers, 0, box);
  for (size_t d = 0; d < 3; ++d) c.normal[d] = parse_number(numbers[3 + d]);
  const double length = std::hypot(c.normal[0], c.normal[1], c.normal[2]);
  ELASTOGEN_CHECK(length > 0 && std::isfinite(length), "its normal has no length");
  for (double& n : c.normal) n /= length;
}

void parse_box(const Texts& numbers, const PlacedBox& box, Collider& c) {
  const Vec3 lower = parse_point(numbers, 0, box), upper = parse_point(numbers, 3, box);
  for (size_t d = 0; d < 3; ++d) {
    ELASTOGEN_CHECK(lower[d] < upper[d], "its lower corner comes first, and along ", "xyz"[d],
                    " it runs from ", lower[d], " to ", upper[d], " m");
    c.centre[d] = (lower[d] + upper[d]) / 2;
    c.half[d] = (upper[d] - lower[d]) / 2;
  }
}

/// The shape, up to its closing bracket. @return what follows it.
std::string_view parse_shape(std::string_view text, const PlacedBox& box, Collider& c) {
  const size_t open = text.find('('), close = text.find(')');
  ELASTOGEN_CHECK(open != text.npos && close != text.npos && open < close, "a bracket is missing");
  const std::string bare = without_blanks(text.substr(0, close));
  const Texts parts = split(bare, '(');
  const std::string_view word = parts[0];
  const Texts numbers = split(parts[1], ',');
  const bool plane = word == "plane", sphere = word == "sphere";
  ELASTOGEN_CHECK(plane || sphere || word == "box", "'", word, "' is none of the known shapes");
  const size_t wanted = sphere ? 4 : 6;
  ELASTOGEN_CHECK(numbers.size() == wanted, "it needs ", wanted, " numbers, got ", numbers.size());
  c.shape = plane ? Shape::kPlane : sphere ? Shape::kSphere : Shape::kBox;
  if (plane) parse_plane(numbers, box, c);
  if (c.shape == Shape::kBox) parse_box(numbers, box, c);
  if (sphere) {
    c.centre = parse_point(numbers, 0, box);
    c.radius = parse_length(numbers[3]);
  }
  return text.substr(close + 1);
}

/// What follows the shape: words friction, name and path, each with what belongs to it.
void parse_rest(std::string_view text, Collider& c) {
  std::istringstream words{std::string(text)};
  std::string word;
  std::vector<std::pair<std::string, std::string>> parts;
  while (words >> word) {
    const bool key = word == "friction" || word == "name" || word == "path";
    ELASTOGEN_CHECK(key || !parts.empty(), "'", word, "' is none of friction, name, path");
    if (key)
      parts.emplace_back(word, "");
    else
      parts.back().second += (parts.back().second.empty() ? "" : " ") + word;
  }
  for (const auto& [key, value] : parts) {
    ELASTOGEN_CHECK(!value.empty(), "nothing follows '", key, "'");
    if (key == "friction") c.friction = parse_number(value);
    if (key == "name") c.name = value;
    if (key == "path") c.path = parse_path(value);
  }
}

}  // namespace

std::vector<PathKey> parse_path(std::string_view text) {
  std::vector<PathKey> path;
  const std::string bare = without_blanks(text);
  for (const std::string_view key : split(bare, ';')) {
    const size_t colon = key.find(':');
    ELASTOGEN_CHECK(colon != key.npos, "its path has '", key, "' where TIME:x,y,z should stand");
    const auto numbers = split(key.substr(colon + 1), ',');
    ELASTOGEN_CHECK(numbers.size() == 3, "its path needs three lengths a time, got '", key, "'");
    PathKey k{.time = parse_time(key.substr(0, colon))};
    for (size_t d = 0; d < 3; ++d) k.offset[d] = parse_length(numbers[d]);
    path.push_back(k);
  }
  return path;
}

Collider parse_collider(std::string_view text, const PlacedBox& box, const std::string& name,
                        double friction) {
  Collider c;
  c.name = name;
  c.friction = friction;
  try {
    parse_rest(parse_shape(text, box, c), c);
  } catch (const Error& error) {
    throw Error(concat("--collider '", text, "': ", error.what(),
                       "; it reads: plane(x,y,z, nx,ny,nz), sphere(x,y,z, r) or box(x0,y0,z0, "
                       "x1,y1,z1), then, if wanted, friction F, name NAME, path T:x,y,z; T:x,y,z"));
  }
  check_collider(c);
  return c;
}

}  // namespace elastogen
