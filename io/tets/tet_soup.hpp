// SPDX-License-Identifier: Apache-2.0
// The tetrahedra as a file has them, which the readers of the formats hand to tet_reader. Its
// linear triangles are used only if it has no tetrahedra.

#pragma once

#include "core/base.hpp"
#include "core/error.hpp"

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace elastogen::tets {

/// All positions are finite and all corners are indices of points.
struct TetSoup {
  std::vector<Vec3> points;      ///< [m]
  int nodes = 0;                 ///< of a tetrahedron, 4 or 10; 0 without any
  std::vector<int32_t> corners;  ///< points in the order of TetFile, nodes a tetrahedron
  std::vector<int64_t> region;   ///< the file's number for the region of each tetrahedron
  int64_t skipped = 0;           ///< points, lines and faces, triangles too

  std::vector<int32_t> triangles;        ///< points, three a linear triangle
  std::vector<int64_t> triangle_region;  ///< the file's number for the region of each

  /// Begins a tetrahedron of this many nodes, whose corners follow.
  void begin_tet(int node_count, int64_t region_id, const std::string& path) {
    ELASTOGEN_CHECK_ASSET(nodes == 0 || nodes == node_count, path,
                          ": it has both linear and quadratic tetrahedra");
    nodes = node_count;
    region.push_back(region_id);
  }
};

/// Gmsh MSH 2 and 4.1, text and binary.
TetSoup parse_msh(std::string_view bytes, const std::string& path);
/// Legacy VTK, text and binary, of all versions.
TetSoup parse_vtk(std::string_view bytes, const std::string& path);
/// VTK's XML for unstructured grids.
TetSoup parse_vtu(std::string_view bytes, const std::string& path);

}  // namespace elastogen::tets
