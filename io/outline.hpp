// SPDX-License-Identifier: Apache-2.0
// The outline of a body in a plane.

#pragma once

#include <array>
#include <string>
#include <vector>

namespace elastogen {

/// Points joined one after the other [m]; one alone is a point, two are a segment.
using Polyline = std::vector<std::array<double, 2>>;

/// What one run looks like in a plane.
struct Outline {
  std::string name;
  std::vector<Polyline> lines;
};

}  // namespace elastogen
