// SPDX-License-Identifier: Apache-2.0
#include "cli/boundary_option.hpp"

#include "cli/collider_option.hpp"
#include "core/error.hpp"
#include "io/byte_reader.hpp"
#include "io/units.hpp"

#include <cmath>

namespace elastogen {
namespace {

using Texts = std::vector<std::string_view>;

struct Parts {
  Selection selection;
  std::string_view rest;
};

/// What stands before and after the first colon: selections have none.
Parts parts_of(std::string_view text) {
  const size_t colon = text.find(':');
  ELASTOGEN_CHECK(colon != text.npos, "the colon behind the selection is missing");
  return {parse_selection(text.substr(0, colon)), trimmed(text.substr(colon + 1))};
}

/// Runs a parser; what it throws then quotes the option and says how it reads.
template <class Call>
auto quoted(const char* option, std::string_view text, const char* grammar, const Call& call) {
  try {
    return call(parts_of(text));
  } catch (const Error& error) {
    throw Error(concat(option, " '", text, "': ", error.what(), " (it reads ", grammar, ')'));
  }
}

std::vector<PathKey> parse_angles(std::string_view text, const Vec3& axis) {
  std::vector<PathKey> path;
  const std::string bare = without_blanks(text);
  for (const std::string_view key : split(bare, ';')) {
    const size_t colon = key.find(':');
    ELASTOGEN_CHECK(colon != key.npos, "'", key, "' stands where TIME:ANGLE should");
    const double angle = parse_angle(key.substr(colon + 1));
    path.push_back({.time = parse_time(key.substr(0, colon)),
                    .offset = {angle * axis[0], angle * axis[1], angle * axis[2]}});
  }
  return path;
}

/// What follows the word turn.
void parse_turn(std::string_view text, MoveOption& move) {
  const size_t open = text.find('('), close = text.find(')');
  ELASTOGEN_CHECK(open == 0 && close != text.npos, "a bracket of the turn is missing");
  const std::string bare = without_blanks(text.substr(1, close - 1));
  const Texts numbers = split(bare, ',');
  ELASTOGEN_CHECK(numbers.size() == 6, "a turn needs 6 numbers, got ", numbers.size());
  Vec3 axis;
  for (size_t d = 0; d < 3; ++d) {
    move.turn_centre[d] = parse_place(numbers[d]);
    axis[d] = parse_number(numbers[3 + d]);
  }
  const double length = std::hypot(axis[0], axis[1], axis[2]);
  ELASTOGEN_CHECK(length > 0 && std::isfinite(length), "its axis has no length");
  for (double& a : axis) a /= length;
  move.turns = true;
  move.path = parse_angles(text.substr(close + 1), axis);
}

MoveOption move_of(const Parts& parts) {
  MoveOption move;
  move.selection = parts.selection;
  constexpr std::string_view kShift = "shift", kTurn = "turn";
  if (parts.rest.starts_with(kShift))
    move.path = parse_path(parts.rest.substr(kShift.size()));
  else if (parts.rest.starts_with(kTurn))
    parse_turn(trimmed(parts.rest.substr(kTurn.size())), move);
  else
    throw Error("neither shift nor turn follows the selection");
  for (size_t k = 1; k < move.path.size(); ++k)
    ELASTOGEN_CHECK(move.path[k - 1].time < move.path[k].time, "its times must ascend");
  return move;
}

}  // namespace

HoldOption parse_hold(std::string_view text) {
  return quoted("--hold", text, "'SELECTION: AXES', e.g. 'x<1%: xz'", [](const Parts& parts) {
    HoldOption hold{.selection = parts.selection};
    ELASTOGEN_CHECK(!parts.rest.empty(), "no axis follows the selection");
    for (const char c : parts.rest) {
      ELASTOGEN_CHECK(c >= 'x' && c <= 'z', "'", parts.rest, "' is none of x, y, z");
      bool& axis = hold.axes[size_t(c - 'x')];
      ELASTOGEN_CHECK(!axis, "'", parts.rest, "' has ", c, " twice");
      axis = true;
    }
    return hold;
  });
}

TractionOption parse_traction(std::string_view text) {
  return quoted("--traction", text,
                "'SELECTION: x,y,z', a force, e.g. 'x>99%: 0,-10,0 N', or 'SELECTION: p', a "
                "pressure, e.g. 'x>99%: 2 kPa'",
                [](const Parts& parts) {
                  TractionOption traction{.selection = parts.selection};
                  if (parts.rest.find(',') == parts.rest.npos)
                    traction.pressure = parse_pressure(parts.rest);
                  else
                    traction.force = parse_vec3(parts.rest, Quantity::kForce);
                  return traction;
                });
}

MoveOption parse_move(std::string_view text) {
  return quoted("--move", text,
                "'SELECTION: shift T:x,y,z; T:x,y,z' or 'SELECTION: turn(x,y,z, ax,ay,az) "
                "T:ANGLE; T:ANGLE'",
                move_of);
}

void check_no_boundary(const AnimateOptions& o, std::string_view verb) {
  for (const auto& [option, texts] :
       {std::pair("--hold", &o.holds), {"--traction", &o.tractions}, {"--move", &o.moves}})
    ELASTOGEN_CHECK(texts->empty(), verb, ": the network has no ", option, ", got '",
                    texts->front(), "'; use simulate");
}

}  // namespace elastogen
