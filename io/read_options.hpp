// SPDX-License-Identifier: Apache-2.0
// Facts about a file that the user states if the file does not, and what is wanted of it.

#pragma once

#include <string>
#include <string_view>

namespace elastogen {

/// Scales and opacities of splats in a PLY file: logarithms and logits (the reference code of 3-D
/// Gaussian splatting), plain numbers, or decided from the numbers (io/ply_splats.hpp).
enum class SplatScales { kAuto, kLog, kLinear };

/// "auto", "log" or "linear". @throws Error naming them.
SplatScales splat_scales_from_name(std::string_view name);
std::string splat_scales_name(SplatScales scales);

struct ReadOptions {
  SplatScales splat_scales = SplatScales::kAuto;
  std::string grid;         ///< name of a grid of an OpenVDB file, "": the first that is not empty
  bool attributes = false;  ///< custom attributes of a glTF are wanted (Mesh::attributes)
};

}  // namespace elastogen
