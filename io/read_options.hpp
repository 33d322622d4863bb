// SPDX-License-Identifier: Apache-2.0
// What a user says of a file where it does not say it itself.

#pragma once

#include <string>
#include <string_view>

namespace elastogen {

/// How a PLY file of splats has its scales and opacities: as logarithms and logits (the reference
/// code of 3-D Gaussian splatting), as they are, or to be found out (io/ply_splats.hpp).
enum class SplatScales { kAuto, kLog, kLinear };

/// "auto", "log" or "linear". @throws Error naming them.
SplatScales splat_scales_from_name(std::string_view name);
std::string splat_scales_name(SplatScales scales);

struct ReadOptions {
  SplatScales splat_scales = SplatScales::kAuto;
  std::string grid;  ///< of an OpenVDB file by its name, "": the first that has something
};

}  // namespace elastogen
