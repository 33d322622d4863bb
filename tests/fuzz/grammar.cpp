// SPDX-License-Identifier: Apache-2.0
// The small languages of the command line; the first byte chooses one.

#include "core/material.hpp"
#include "io/asset_pose.hpp"
#include "io/units.hpp"
#include "scene/boundary.hpp"
#include "scene/material_region.hpp"
#include "scene/obstacle.hpp"
#include "tests/fuzz/harness.hpp"
#include "voxelize/regions.hpp"

#include <cmath>
#include <cstddef>
#include <cstdint>

namespace elastogen {
namespace {

const PlacedBox kBox = {{{-1, 0, 2}, {1, 3, 2.5}}};

void require_finite(double x) {
  fuzz::require(std::isfinite(x), "a number that was read is finite");
}

void selection(std::string_view text) {
  const Selection s = parse_selection(text);
  if (s.is_place()) contains(s, {0.1, 0.2, 2.1}, kBox);
  if (const auto p = plane(s, kBox)) require_finite(p->second);
  require_finite(s.radius);
  require_finite(s.bound);
}

void collider(std::string_view text) {
  const Collider c = place_obstacle(parse_obstacle(text), kBox, "name", 0.3);
  for (size_t d = 0; d < 3; ++d) {
    require_finite(c.centre[d]);
    require_finite(c.normal[d]);
    require_finite(c.half[d]);
  }
  require_finite(c.radius);
  require_finite(c.friction);
}

void region(std::string_view text) {
  check_material(parse_region(text).material);
}

void boundary(std::string_view text) {
  if (text.empty()) return;
  const int kind = uint8_t(text[0]) % 5;
  text.remove_prefix(1);
  if (kind == 0) parse_hold(text);
  if (kind == 1) {
    const Traction traction = parse_traction(text);
    for (const double f : traction.force) require_finite(f);
    require_finite(traction.pressure.value_or(0));
  }
  if (kind == 2)
    for (const PathKey& key : parse_move(text).path.keys)
      for (const double x : key.offset) require_finite(x);
  if (kind > 2)
    for (const PathKey& key : (kind == 3 ? parse_force(text).force : parse_wind(text)).keys)
      for (const double x : key.offset) require_finite(x);
}

void quantity(std::string_view text) {
  if (text.empty()) return;
  const auto kind = Quantity(uint8_t(text[0]) % (int(Quantity::kMemory) + 1));
  text.remove_prefix(1);
  for (const double x : parse_vec3(text, kind)) require_finite(x);
}

void memory(std::string_view text) {
  fuzz::require(parse_memory(text) >= 0, "a memory is not negative");
}

void place(std::string_view text) {
  require_finite(parse_place(text).value);
}

void up(std::string_view text) {
  up_from_name(text);
}

}  // namespace
}  // namespace elastogen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace elastogen;
  constexpr void (*kLanguages[])(std::string_view) = {selection, collider, region, quantity,
                                                      memory,    place,    up,     boundary};
  if (size == 0) return 0;
  const std::string_view text(reinterpret_cast<const char*>(data + 1), size - 1);
  try {
    kLanguages[data[0] % std::size(kLanguages)](text);
  } catch (const Error& error) {
    fuzz::require_kind(error, ErrorKind::kUsage);
  }
  return 0;
}
