// SPDX-License-Identifier: Apache-2.0
#include "voxelize/regions.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "io/byte_reader.hpp"
#include "io/units.hpp"

#include <algorithm>
#include <cassert>
#include <charconv>
#include <cmath>
#include <string>
#include <vector>

namespace elastogen {
namespace {

constexpr double kBorder = 1e-9;  // width of a border over the box's longest edge

[[noreturn]] void refuse(std::string_view text, const std::string& why) {
  throw Error(concat("selection '", text, "': ", why,
                     "; it reads: all, AXIS<PLACE, AXIS>PLACE, box(x0,y0,z0,x1,y1,z1) or "
                     "sphere(x,y,z,RADIUS), where AXIS is x, y or z and PLACE a length (0.2m, 3cm) "
                     "or a share of the asset's box (5%); or node:NAME, material:NAME, "
                     "colour:#RRGGBB, attr:NAME>NUMBER"));
}

Selection parse_half_space(std::string_view text) {
  Selection selection;
  selection.kind = Selection::Kind::kHalfSpace;
  selection.axis = text[0] - 'x';
  selection.below = text[1] == '<';
  selection.lower[selection.axis] = parse_place(text.substr(text[2] == '=' ? 3 : 2));
  return selection;
}

Selection parse_box(const std::vector<std::string_view>& numbers) {
  Selection selection;
  selection.kind = Selection::Kind::kBox;
  for (int d = 0; d < 3; ++d) {
    selection.lower[d] = parse_place(numbers[d]);
    selection.upper[d] = parse_place(numbers[d + 3]);
    if (selection.lower[d].percent == selection.upper[d].percent)
      ELASTOGEN_CHECK(selection.lower[d].value <= selection.upper[d].value,
                      "its lower corner comes first");
  }
  return selection;
}

Selection parse_sphere(const std::vector<std::string_view>& numbers) {
  Selection selection;
  selection.kind = Selection::Kind::kSphere;
  for (int d = 0; d < 3; ++d) selection.lower[d] = parse_place(numbers[d]);
  selection.radius = parse_length(numbers[3]);
  ELASTOGEN_CHECK(selection.radius > 0, "its radius must be positive");
  return selection;
}

struct Word {
  std::string_view text;
  Selection::Kind kind;
};
constexpr Word kWords[] = {{"node:", Selection::Kind::kNode},
                           {"material:", Selection::Kind::kMaterial},
                           {"colour:", Selection::Kind::kColour},
                           {"color:", Selection::Kind::kColour},
                           {"attr:", Selection::Kind::kAttribute}};

/// The word with which a part of the asset begins; null for places.
const Word* word_of(std::string_view text) {
  for (const Word& word : kWords)
    if (text.starts_with(word.text)) return &word;
  return nullptr;
}

void parse_colour(std::string_view text, Selection& selection) {
  unsigned number = 0;
  const char* end = text.data() + text.size();
  const bool read = text.size() == 7 && text[0] == '#' &&
                    std::from_chars(text.data() + 1, end, number, 16).ptr == end;
  ELASTOGEN_CHECK(read, "'", text, "' is no #RRGGBB");
  for (size_t c = 0; c < 3; ++c) selection.colour[c] = uint8_t(number >> (16 - 8 * c));
}

void parse_attribute(std::string_view text, Selection& selection) {
  const size_t at = text.find_last_of("<>");
  ELASTOGEN_CHECK(at != text.npos, "'", text, "' is no comparison of an attribute");
  selection.below = text[at] == '<';
  selection.with_bound = text.substr(at + 1).starts_with('=');
  selection.bound = parse_number(text.substr(at + (selection.with_bound ? 2 : 1)));
  selection.name = trimmed(text.substr(0, at));
}

Selection parse_part(const Word& word, std::string_view text) {
  Selection selection;
  selection.kind = word.kind;
  if (word.kind == Selection::Kind::kColour)
    parse_colour(text, selection);
  else if (word.kind == Selection::Kind::kAttribute)
    parse_attribute(text, selection);
  else
    selection.name = text;
  ELASTOGEN_CHECK(word.kind == Selection::Kind::kColour || !selection.name.empty(),
                  "nothing follows '", word.text, "'");
  return selection;
}

/// @param bare  text without blanks.
Selection parse_place_words(std::string_view bare) {
  if (bare == "all") return {};
  if (bare.size() > 2 && bare[0] >= 'x' && bare[0] <= 'z' && (bare[1] == '<' || bare[1] == '>'))
    return parse_half_space(bare);
  const bool box = bare.starts_with("box("), sphere = bare.starts_with("sphere(");
  ELASTOGEN_CHECK(box || sphere, "it begins with none of the known words");
  ELASTOGEN_CHECK(bare.ends_with(')'), "the closing bracket is missing");
  bare.remove_suffix(1);
  const auto numbers = split(bare.substr(bare.find('(') + 1), ',');
  const size_t wanted = box ? 6 : 4;
  ELASTOGEN_CHECK(numbers.size() == wanted, "it needs ", wanted, " numbers, got ", numbers.size());
  return box ? parse_box(numbers) : parse_sphere(numbers);
}

}  // namespace

std::string without_blanks(std::string_view text) {
  const auto is_digit = [](char c) { return (c >= '0' && c <= '9') || c == '.'; };
  std::string bare;
  bool parted = false;
  for (const char c : text) {
    const bool blank = c == ' ' || c == '\t';
    ELASTOGEN_CHECK(!(parted && is_digit(c) && is_digit(bare.back())),
                    "a blank parts two numbers, where a comma should stand");
    if (!blank) bare += c;
    parted = blank && !bare.empty();
  }
  return bare;
}

std::vector<std::string_view> split(std::string_view text, char at) {
  std::vector<std::string_view> parts;
  for (size_t end; (end = text.find(at)) != text.npos; text.remove_prefix(end + 1))
    parts.push_back(text.substr(0, end));
  parts.push_back(text);
  return parts;
}

Place parse_place(std::string_view text) {
  if (text.ends_with('%')) return {parse_number(text.substr(0, text.size() - 1)) / 100, true};
  return {parse_length(text), false};
}

double coordinate(const Place& place, int axis, const PlacedBox& box) {
  return place.percent ? box.lower[axis] + place.value * box.extent(axis)
                       : place.value - box.origin[axis];
}

Selection parse_selection(std::string_view text) {
  try {
    const Word* word = word_of(trimmed(text));
    return word ? parse_part(*word, trimmed(trimmed(text).substr(word->text.size())))
                : parse_place_words(without_blanks(text));
  } catch (const Error& error) {
    refuse(text, error.what());
  }
}

std::pair<std::string_view, std::string_view> split_selection(std::string_view text) {
  text = trimmed(text);
  const Word* word = word_of(text);
  const size_t first = word ? word->text.size() : 0;
  size_t colon = word ? std::min(text.find(": ", first), text.find(":\t", first)) : text.npos;
  if (colon == text.npos) colon = text.find(':', first);
  ELASTOGEN_CHECK(colon != text.npos, "the colon behind the selection is missing");
  return {text.substr(0, colon), trimmed(text.substr(colon + 1))};
}

bool contains(const Selection& selection, const Vec3& point, const PlacedBox& box) {
  assert(selection.is_place());
  const double border = kBorder * std::max({box.extent(0), box.extent(1), box.extent(2)});
  double distance2 = 0;
  // each kind with a margin for rounding
  switch (selection.kind) {
    case Selection::Kind::kAll:
      return true;
    case Selection::Kind::kHalfSpace: {
      const double from =
          point[selection.axis] - coordinate(selection.lower[selection.axis], selection.axis, box);
      return selection.below ? from <= border : from >= -border;
    }
    case Selection::Kind::kBox:
      for (int d = 0; d < 3; ++d)
        if (point[d] < coordinate(selection.lower[d], d, box) - border ||
            point[d] > coordinate(selection.upper[d], d, box) + border)
          return false;
      return true;
    case Selection::Kind::kSphere:
      for (int d = 0; d < 3; ++d)
        distance2 += std::pow(point[d] - coordinate(selection.lower[d], d, box), 2);
      return std::sqrt(distance2) <= selection.radius + border;
    default:
      break;
  }
  return false;
}

Array<uint8_t> select_nodes(const VoxelGrid& grid, const Selection& selection,
                            const PlacedBox& box) {
  Array<uint8_t> selected(grid.node_count());
  for_each(grid.node_count(), [&](int64_t n) {
    selected(n) = contains(selection, {grid.rest(n, 0), grid.rest(n, 1), grid.rest(n, 2)}, box);
  });
  return selected;
}

std::optional<std::pair<int, double>> plane(const Selection& selection, const PlacedBox& box) {
  if (selection.kind != Selection::Kind::kHalfSpace) return std::nullopt;
  const int axis = selection.axis;
  return std::pair{axis, coordinate(selection.lower[axis], axis, box)};
}

}  // namespace elastogen
