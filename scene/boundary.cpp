// SPDX-License-Identifier: Apache-2.0
#include "scene/boundary.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "io/byte_reader.hpp"
#include "io/units.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

using Texts = std::vector<std::string_view>;

struct Parts {
  Selection selection;
  std::string_view rest;
};

Parts parts_of(std::string_view text) {
  const auto [selection, rest] = split_selection(text);
  return {parse_selection(selection), rest};
}

/// Runs a parser; adds the text of the option and its grammar to errors.
template <class Call>
auto quoted(const char* option, std::string_view text, const char* grammar, const Call& call) {
  try {
    return call(parts_of(text));
  } catch (const Error& error) {
    throw Error(concat(option, " '", text, "': ", error.what(), " (it reads ", grammar, ')'));
  }
}

/// Takes the words ease and loop from the front of a path, in any order.
/// @return the text behind them.
std::string_view take_words(std::string_view text, Path& path) {
  while (true) {
    text = trimmed(text);
    const size_t end = std::min(text.find_first_of(" \t"), text.size());
    const std::string_view word = text.substr(0, end);
    if (word != "ease" && word != "loop") return text;
    (word == "ease" ? path.eases : path.loops) = true;
    text.remove_prefix(end);
  }
}

/// Reads keys: offset_of makes an offset of the text behind the time, or says what should stand there.
template <class OffsetOf>
Path parse_keys(std::string_view text, const char* grammar, const OffsetOf& offset_of) {
  Path path;
  const std::string bare = without_blanks(take_words(text, path));
  for (const std::string_view key : split(bare, ';')) {
    const size_t colon = key.find(':');
    ELASTOGEN_CHECK(colon != key.npos, "its path has '", key, "' where ", grammar, " should stand");
    path.keys.push_back({.time = parse_time(key.substr(0, colon)),
                         .offset = offset_of(key, key.substr(colon + 1))});
  }
  return path;
}

Path parse_angles(std::string_view text, const Vec3& axis) {
  return parse_keys(text, "TIME:ANGLE", [&](std::string_view, std::string_view angle) {
    return scaled(axis, parse_angle(angle));
  });
}

/// @throws Error unless a path that loops ends as it begins, or whole turns further.
void check_loop(const Move& move) {
  if (!move.path.loops) return;
  const Vec3 rest = minus(move.path.keys.back().offset, move.path.keys.front().offset);
  const double turns = norm(rest) / (2 * std::numbers::pi);
  const bool closed = move.turns ? std::abs(turns - std::round(turns)) < 1e-9 : rest == Vec3{};
  ELASTOGEN_CHECK(closed, "a path that loops must end as it begins");
}

/// Reads the text after the word turn.
void parse_turn(std::string_view text, Move& move) {
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

Move move_of(const Parts& parts) {
  Move move;
  move.selection = parts.selection;
  constexpr std::string_view kShift = "shift", kTurn = "turn";
  if (parts.rest.starts_with(kShift))
    move.path = parse_path(parts.rest.substr(kShift.size()));
  else if (parts.rest.starts_with(kTurn))
    parse_turn(trimmed(parts.rest.substr(kTurn.size())), move);
  else
    throw Error("neither shift nor turn follows the selection");
  check_path(move.path);
  check_loop(move);
  return move;
}

}  // namespace

Path parse_path(std::string_view text) {
  return parse_keys(text, "TIME:x,y,z", [](std::string_view key, std::string_view offset) {
    const auto numbers = split(offset, ',');
    ELASTOGEN_CHECK(numbers.size() == 3, "its path needs three lengths a time, got '", key, "'");
    return Vec3{parse_length(numbers[0]), parse_length(numbers[1]), parse_length(numbers[2])};
  });
}

Pin parse_pin(std::string_view text) {
  return {std::string(text), parse_selection(text)};
}

Hold parse_hold(std::string_view text) {
  return quoted("--hold", text, "'SELECTION: AXES', e.g. 'x<1%: xz'", [text](const Parts& parts) {
    Hold hold{.text = std::string(text), .selection = parts.selection};
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

Traction parse_traction(std::string_view text) {
  return quoted("--traction", text,
                "'SELECTION: x,y,z', a force, e.g. 'x>99%: 0,-10,0 N', or 'SELECTION: p', a "
                "pressure, e.g. 'x>99%: 2 kPa'",
                [text](const Parts& parts) {
                  Traction traction{.text = std::string(text), .selection = parts.selection};
                  if (parts.rest.find(',') == parts.rest.npos)
                    traction.pressure = parse_pressure(parts.rest);
                  else
                    traction.force = parse_vec3(parts.rest, Quantity::kForce);
                  return traction;
                });
}

/// Reads a vector that is constant, or keys.
Path parse_vectors(std::string_view text, Quantity quantity) {
  if (text.find(':') == text.npos) return {{0, parse_vec3(text, quantity)}};
  Path path = parse_keys(text, "TIME:x,y,z", [&](std::string_view, std::string_view value) {
    return parse_vec3(value, quantity);
  });
  check_path(path);
  return path;
}

Force parse_force(std::string_view text) {
  return quoted("--force", text,
                "'SELECTION: x,y,z', e.g. 'y>80%: 10,0,0 N', or 'SELECTION: TIME:x,y,z; "
                "TIME:x,y,z'",
                [text](const Parts& parts) {
                  return Force{std::string(text), parts.selection,
                               parse_vectors(parts.rest, Quantity::kForce)};
                });
}

Path parse_wind(std::string_view text) {
  try {
    return parse_vectors(text, Quantity::kSpeed);
  } catch (const Error& error) {
    throw Error(concat("--wind '", text, "': ", error.what(),
                       " (it reads x,y,z in m/s, or TIME:x,y,z; TIME:x,y,z)"));
  }
}

Move parse_move(std::string_view text) {
  Move move = quoted("--move", text,
                     "'SELECTION: shift T:x,y,z; T:x,y,z' or 'SELECTION: turn(x,y,z, ax,ay,az) "
                     "T:ANGLE; T:ANGLE'",
                     move_of);
  move.text = text;
  return move;
}

}  // namespace elastogen
