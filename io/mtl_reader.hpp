// SPDX-License-Identifier: Apache-2.0
// MTL, the material files of OBJ.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// Fills the materials that the asset already names from an MTL file beside it: Kd, d or Tr, map_Kd
/// (a missing texture is a finding). Lines that cannot be read are skipped.
/// @return false if the file is not within the asset's folder.
bool read_mtl(Asset& asset, const std::string& name);

}  // namespace elastogen
