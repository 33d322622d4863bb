// SPDX-License-Identifier: Apache-2.0
// The check behind every reader: what a file must not contain, and what it should not contain.

#pragma once

#include "io/asset.hpp"
#include "io/weld.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

/// Adds to the finding of that id, or makes it with the sentence.
void add_finding(Asset& asset, const std::string& what, int64_t count, const std::string& text);

template <class Values>
bool are_finite(const Values& values) {
  return std::ranges::all_of(values, [](auto x) { return std::isfinite(x); });
}

/// Sets rows that are not finite to a value, with a finding bad-NAME.
template <class Row>
void reset_bad_rows(Asset& asset, std::vector<Row>& rows, const Row& value, const char* name) {
  int64_t bad = 0;
  for (Row& row : rows) {
    if (are_finite(row)) continue;
    row = value;
    ++bad;
  }
  add_finding(asset, std::string("bad-") + name, bad,
              std::string(name) + " that were not finite were reset");
}

/// Refuses what cannot be simulated, repairs attributes, adds findings (see docs/formats.md).
/// Repairs: uv, normals and colours that are not finite become 0, (0, 0, 1) and white. Except for
/// glTF, whose document outputs keep: normals get the length one, textures without uv are dropped.
/// Assets of points or splats need no triangle (io/cloud_check.hpp).
/// @throws Error (asset) naming file, mesh and first index: a position that is not finite, a
///         corner out of range, no triangle ("nothing to simulate"), no extent.
void check_asset(Asset& asset);

}  // namespace elastogen
