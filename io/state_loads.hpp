// SPDX-License-Identifier: Apache-2.0
// The part of a state file that tells where loads that change come from (docs/formats.md, state).

#pragma once

#include "core/scene.hpp"
#include "io/hdf5_file.hpp"
#include "io/state_writer.hpp"

#include <vector>

namespace elastogen {

/// Whether the steps of a run have loads that change.
bool has_changing_loads(const Scene& scene, const StateHeader& header);

/// Writes /forces and /wind, where there are any, with what they do at each time but the first [s].
void write_loads(hid_t file, const Scene& scene, const StateHeader& header,
                 const std::vector<double>& times);

}  // namespace elastogen
