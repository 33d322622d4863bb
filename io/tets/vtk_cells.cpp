// SPDX-License-Identifier: Apache-2.0
#include "io/tets/vtk_cells.hpp"

#include <algorithm>

namespace elastogen::tets {
namespace {

constexpr int64_t kTriangle = 5, kTet4 = 10, kTet10 = 24;

/// Vertices, lines, triangles, polygons and quads, linear and quadratic (vtkCellType.h).
bool is_skipped(int64_t type) {
  constexpr int64_t kTypes[] = {1, 2, 3, 4, 5, 6, 7, 8, 9, 21, 22, 23, 28, 30, 34, 35};
  return std::find(std::begin(kTypes), std::end(kTypes), type) != std::end(kTypes);
}

const char* cell_name(int64_t type) {
  // numbers of vtkCellType.h; linear and quadratic cells of one shape share a name
  switch (type) {
    case 11:
      return "a voxel";
    case 12:
    case 25:
    case 29:
    case 33:
      return "a hexahedron";
    case 13:
    case 26:
    case 31:
    case 32:
      return "a wedge";
    case 14:
    case 27:
      return "a pyramid";
    case 42:
      return "a polyhedron";
    case 71:
      return "a Lagrange tetrahedron";
    case 78:
      return "a Bezier tetrahedron";
    default:
      return "unknown";
  }
}

void add_triangle(const VtkCells& cells, int64_t cell, int64_t begin, int64_t end,
                  const std::string& path, TetSoup& soup) {
  ELASTOGEN_CHECK_ASSET(end - begin == 3, path, ": cell ", cell,
                        " (counted from 0) is a triangle, but has ", end - begin, " points");
  soup.triangle_region.push_back(cells.region.empty() ? 0 : cells.region[size_t(cell)]);
  soup.triangles.insert(soup.triangles.end(), cells.corners.begin() + begin,
                        cells.corners.begin() + end);
}

}  // namespace

bool is_region_name(std::string_view name) {
  return name == "region" || name == "material" || name == "gmsh:physical" ||
         name == "gmsh:geometrical";
}

void add_tets(const VtkCells& cells, const std::string& path, TetSoup& soup) {
  const auto count = int64_t(cells.types.size());
  ELASTOGEN_CHECK_ASSET(int64_t(cells.ends.size()) == count, path, ": it has ", count,
                        " types of cells, but points of ", cells.ends.size());
  int64_t begin = 0;
  // each cell must lie behind the one before it
  for (int64_t c = 0; c < count; ++c) {
    const int64_t end = cells.ends[size_t(c)], type = cells.types[size_t(c)];
    ELASTOGEN_CHECK_ASSET(end >= begin && end <= int64_t(cells.corners.size()), path, ": cell ", c,
                          " (counted from 0) ends at point ", end, " of ", cells.corners.size(),
                          " and begins at ", begin);
    // tetrahedra
    if (type == kTet4 || type == kTet10) {
      const int nodes = type == kTet4 ? 4 : 10;
      ELASTOGEN_CHECK_ASSET(end - begin == nodes, path, ": cell ", c,
                            " (counted from 0) is a "
                            "tetrahedron of ",
                            nodes, " points, but has ", end - begin);
      soup.begin_tet(nodes, cells.region.empty() ? 0 : cells.region[size_t(c)], path);
      soup.corners.insert(soup.corners.end(), cells.corners.begin() + begin,
                          cells.corners.begin() + end);
    } else {
      // other cells are counted; triangles are kept for files without tetrahedra
      ELASTOGEN_CHECK_ASSET(is_skipped(type), path, ": cell ", c, " (counted from 0) is of type ",
                            type, " (", cell_name(type),
                            "), which is not read; only tetrahedra of 4 and 10 points are");
      ++soup.skipped;
      if (type == kTriangle) add_triangle(cells, c, begin, end, path, soup);
    }
    begin = end;
  }
  ELASTOGEN_CHECK_ASSET(begin == int64_t(cells.corners.size()), path, ": its cells have ", begin,
                        " points, but ", cells.corners.size(), " are listed");
}

}  // namespace elastogen::tets
