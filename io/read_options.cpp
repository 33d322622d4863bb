// SPDX-License-Identifier: Apache-2.0
#include "io/read_options.hpp"

#include "core/error.hpp"

namespace elastogen {
namespace {

constexpr const char* kScalesNames[] = {"auto", "log", "linear"};

}  // namespace

SplatScales splat_scales_from_name(std::string_view name) {
  for (int k = 0; k < 3; ++k)
    if (name == kScalesNames[k]) return SplatScales(k);
  throw Error(concat("--splat-scales '", name, "': known are auto, log and linear"));
}

std::string splat_scales_name(SplatScales scales) {
  return kScalesNames[int(scales)];
}

}  // namespace elastogen
