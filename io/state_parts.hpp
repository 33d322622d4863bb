// SPDX-License-Identifier: Apache-2.0
// Parts of a state file: materials and colliders. Not a public header: only io/*.cpp may include it.

#pragma once

#include "core/scene.hpp"
#include "io/hdf5_file.hpp"
#include "io/state_writer.hpp"

namespace elastogen {

/// Dataset `name` of a group, (names) of text.
void write_names(hid_t group, const std::vector<std::string>& names);
/// /materials, a compound.
void write_materials(hid_t file, const std::vector<Material>& materials);
/// /contact, if there are colliders.
/// @param times  of the entries [s].
void write_contact(hid_t file, const Scene& scene, const StateHeader& header,
                   const std::vector<double>& times);

}  // namespace elastogen
