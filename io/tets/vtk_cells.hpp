// SPDX-License-Identifier: Apache-2.0
// Cells as both VTK formats have them.

#pragma once

#include "io/tets/tet_soup.hpp"

namespace elastogen::tets {

struct VtkCells {
  std::vector<int32_t> corners;  ///< points of the cells, one cell behind the other
  std::vector<int64_t> ends;     ///< where the points of each cell end
  std::vector<int64_t> types;    ///< VTK's numbers
  std::vector<int64_t> region;   ///< of each cell; empty: 0
};

/// Adds the tetrahedra among the cells; their points are in range already.
/// @throws Error (asset) naming the first cell that is not what it should be.
void add_tets(const VtkCells& cells, const std::string& path, TetSoup& soup);

/// Whether an array of cells says to which region they belong.
bool is_region_name(std::string_view name);

}  // namespace elastogen::tets
