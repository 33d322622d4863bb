// SPDX-License-Identifier: Apache-2.0
// Cells in the form that both VTK formats share.

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

/// Whether an array of this name says to which region the cells belong.
bool is_region_name(std::string_view name);

}  // namespace elastogen::tets
