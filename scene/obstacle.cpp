// SPDX-License-Identifier: Apache-2.0
#include "scene/obstacle.hpp"

#include "core/error.hpp"
#include "io/units.hpp"
#include "scene/boundary.hpp"

#include <cmath>
#include <sstream>
#include <vector>

namespace elastogen {
namespace {

using Shape = Collider::Shape;

using Texts = std::vector<std::string_view>;

std::array<Place, 3> parse_point(const Texts& numbers, size_t first) {
  std::array<Place, 3> point;
  for (size_t d = 0; d < 3; ++d) point[d] = parse_place(numbers[first + d]);
  return point;
}

Vec3 parse_normal(const Texts& numbers) {
  Vec3 normal;
  for (size_t d = 0; d < 3; ++d) normal[d] = parse_number(numbers[3 + d]);
  const double length = std::hypot(normal[0], normal[1], normal[2]);
  ELASTOGEN_CHECK(length > 0 && std::isfinite(length), "its normal has no length");
  for (double& n : normal) n /= length;
  return normal;
}

/// Reads the shape up to its closing bracket. @return the text after it.
std::string_view parse_shape(std::string_view text, Obstacle& o) {
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
  o.shape = plane ? Shape::kPlane : sphere ? Shape::kSphere : Shape::kBox;
  o.point = parse_point(numbers, 0);
  if (plane) o.normal = parse_normal(numbers);
  if (o.shape == Shape::kBox) o.upper = parse_point(numbers, 3);
  if (sphere) o.radius = parse_length(numbers[3]);
  return text.substr(close + 1);
}

/// Reads the text after the shape: the words friction, name and path, each with its values.
void parse_rest(std::string_view text, Obstacle& o) {
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
    if (key == "friction") o.friction = parse_friction(value);
    if (key == "name") o.name = value;
    if (key == "path") o.path = parse_path(value);
  }
}

Vec3 place_point(const std::array<Place, 3>& place, const PlacedBox& box) {
  Vec3 point;
  for (size_t d = 0; d < 3; ++d) point[d] = coordinate(place[d], int(d), box);
  return point;
}

void place_box(const Obstacle& o, const PlacedBox& box, Collider& c) {
  const Vec3 lower = place_point(o.point, box), upper = place_point(o.upper, box);
  for (size_t d = 0; d < 3; ++d) {
    ELASTOGEN_CHECK(lower[d] < upper[d], "its lower corner comes first, and along ", "xyz"[d],
                    " it runs from ", lower[d], " to ", upper[d], " m");
    c.centre[d] = (lower[d] + upper[d]) / 2;
    c.half[d] = (upper[d] - lower[d]) / 2;
  }
}

/// Runs an action; adds the text and the grammar to its errors.
template <class Action>
void quoted(std::string_view text, const Action& action) {
  try {
    action();
  } catch (const Error& error) {
    throw Error(concat(
        "--collider '", text, "': ", error.what(),
        "; it reads: plane(x,y,z, nx,ny,nz), sphere(x,y,z, r) or box(x0,y0,z0, "
        "x1,y1,z1), then, if wanted, friction F (or sticky), name NAME, path T:x,y,z; T:x,y,z"));
  }
}

}  // namespace

double parse_friction(std::string_view text) {
  return without_blanks(text) == "sticky" ? kSticks : parse_number(text);
}

Obstacle parse_obstacle(std::string_view text) {
  Obstacle o{.text = std::string(text)};
  quoted(text, [&] { parse_rest(parse_shape(text, o), o); });
  return o;
}

Collider place_obstacle(const Obstacle& o, const PlacedBox& box, const std::string& name,
                        double friction) {
  Collider c;
  c.shape = o.shape;
  c.name = o.name.empty() ? name : o.name;
  c.friction = o.friction.value_or(friction);
  c.path = o.path;
  if (o.shape == Shape::kPlane) c.normal = o.normal;
  if (o.shape == Shape::kSphere) c.radius = o.radius;
  quoted(o.text, [&] {
    if (o.shape == Shape::kBox)
      place_box(o, box, c);
    else
      c.centre = place_point(o.point, box);
  });
  check_collider(c);
  return c;
}

}  // namespace elastogen
