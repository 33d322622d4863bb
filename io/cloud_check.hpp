// SPDX-License-Identifier: Apache-2.0
// The check behind every reader of points and splats; io/asset_check.hpp calls it.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// Drops points and splats that are not finite (findings bad-points, bad-splats): of a splat the
/// position, the scale, which may not be negative either, and the opacity. The others keep their
/// order. Normalises rotations and sets those of no length to the identity (bad-rotations), normals
/// that are not finite to (0, 0, 1), colours to white, harmonics to 0 (bad-harmonics); a scale of 0
/// becomes the least float, so that it has a logarithm.
/// @throws Error (asset): nothing is left, all points lie in one place, they are out of range.
void check_cloud(Asset& asset);

}  // namespace elastogen
