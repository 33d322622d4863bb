// SPDX-License-Identifier: Apache-2.0
// Reads tetrahedral meshes, linear and quadratic, and linear triangles in the plane z = 0 from Gmsh
// MSH 2 and 4.1, legacy VTK and VTU. Files are not trusted: counts are compared with the bytes that
// are there before memory is allocated.

#pragma once

#include "core/array.hpp"

#include <string>
#include <string_view>
#include <vector>

namespace elastogen::tets {

struct TetFile {
  Array<double> rest;               ///< nodes in the file's order [m], (nodes, 3)
  Array<int32_t> elements;          ///< nodes of each tetrahedron, (elements, 4 or 10): corners
                                    ///< 0 to 3 with positive volume, then the middles of the edges
                                    ///< 01, 12, 02, 03, 13, 23; if the file has no tetrahedra,
                                    ///< its triangles, counterclockwise, (elements, 3)
  Array<int32_t> region;            ///< index into region_ids of each tetrahedron, (elements, 1)
  std::vector<int64_t> region_ids;  ///< the file's numbers of its regions, ascending
  int64_t turned = 0;   ///< elements of negative volume, two corners of which were swapped
  int64_t skipped = 0;  ///< points, lines and faces, which are left out
  int64_t unused = 0;   ///< points of no element, which are left out
};

/// The tetrahedra in the bytes of a file, whose first bytes tell the format. Numbers are metres.
///
/// MSH 2 and 4.1, text and binary: the region is the first physical group, else the entity. Legacy
/// VTK, text and binary: UNSTRUCTURED_GRID. VTU: one piece; arrays as text, base64 or raw, inline
/// or appended, plain or packed by zlib. In the last two the region is the first array of one
/// integer a cell that is called region, material, gmsh:physical or gmsh:geometrical, else 0.
///
/// @param path  for messages.
/// @throws Error (asset) with file and place: a damaged or foreign file, a number that is not
///         finite, an index out of range, elements other than tetrahedra, points, lines and faces,
///         linear and quadratic tetrahedra together, a tetrahedron that is flat but for rounding,
///         none at all unless there are linear triangles, all in the plane z = 0.
TetFile parse_tets(std::string_view bytes, const std::string& path);

/// Reads tetrahedra from a file.
TetFile read_tets(const std::string& path);

}  // namespace elastogen::tets
