// SPDX-License-Identifier: Apache-2.0
// The parts of the verb `materials` that make or use nets.

#pragma once

#include "cli/options.hpp"

namespace elastogen {

/// Writes the page of the net that `animate --energy neural` uses for a law or a preset.
/// @return 0, or 4 if the net misses its limits.
int report_material(const MaterialsTask& task);

/// Makes a weight file for a law or sum of laws. @return 0, or 4 if it misses its limits.
int generate_material(const MaterialsTask& task);

/// Fits laws to a material test, prints how well each fits and whether the net of the best keeps
/// its limits, and writes a scene with that material. @return 0.
int fit_material_test(const MaterialsTask& task);

}  // namespace elastogen
