// SPDX-License-Identifier: Apache-2.0
// The loads of material tests. A homogeneous body is stretched along some axes and free of traction
// along the others (Treloar, The Physics of Rubber Elasticity, chapter 5). With E = 1.

#pragma once

#include "core/base.hpp"
#include "training/fit_material.hpp"

#include <optional>
#include <string>

namespace elastogen {

enum class LoadPath : uint8_t {
  kUniaxial,  ///< stretches (l, b, b), b free
  kBiaxial,   ///< (l, l, b), b free
  kShear,     ///< (l, 1, b), b free: planar tension, which is pure shear
  kVolume,    ///< (l, l, l), none free
};

/// "uniaxial", "biaxial", "shear" or "volume".
std::string path_name(LoadPath path);

/// State of a body under a load.
struct LoadState {
  Vec3 e;             ///< principal log stretches
  double stress = 0;  ///< nominal (first Piola-Kirchhoff) along the first axis [E]
  double energy = 0;  ///< per volume at rest [E]
};

/// The state in which the law has no traction on the free sides (dpsi/ds = 0), of several the one
/// nearest to that of the linear theory. No value if there is none with log stretches within 8:
/// StVK has none for s^2 > 1 + 1/nu in uniaxial tension.
/// @param stretch  l, > 0.
/// @throws Error for a stretch that is not positive and finite.
std::optional<LoadState> balanced_state(const TargetLaw& law, LoadPath path, double stretch);

}  // namespace elastogen
