// SPDX-License-Identifier: Apache-2.0
// The parts of a state file that tell what holds the body (docs/formats.md, state).

#pragma once

#include "core/scene.hpp"
#include "io/hdf5_file.hpp"
#include "io/state_writer.hpp"

#include <vector>

namespace elastogen {

/// Writes the dependent nodes into /grid: a row for each parent node of each.
void write_dependent(hid_t group, const DependentNodes& dependent);

/// Writes /holders: their names, the holder of each node, and where one moves what dependent nodes are
/// offset by, at each time [s].
void write_holders(hid_t file, const Scene& scene, const StateHeader& header,
                   const std::vector<double>& times);

/// Writes the reactions of all steps, of each holder, into /steps; nothing where they are not known.
void write_reactions(hid_t group, size_t holders, const std::vector<Reaction>& reactions);

}  // namespace elastogen
