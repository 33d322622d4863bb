// SPDX-License-Identifier: Apache-2.0
// Surfaces with every vertex and every triangle once, and the findings from their edges: closed or
// open, wound well or badly. The asset check and the voxeliser use it for their decisions.

#pragma once

#include "io/asset.hpp"

namespace elastogen {

/// Distance below which vertices count as one, as a share of the longest edge of the box of the
/// vertices that triangles use. It is raised to 4 eps |x|_max where the surface lies so far from
/// the origin that its own numbers are coarser.
inline constexpr double kWeldTolerance = 1e-6;

/// A surface in which vertices closer than the tolerance are one. Triangles with fewer than three
/// different welded vertices are left out. If several triangles have the same three vertices,
/// the first one of the winding that prevails stays. If both windings are equally frequent (a leaf
/// drawn from both sides, two solids that touch, a face and its turned copy), one stays or a pair
/// stays, whichever leaves fewer unbalanced edges in the whole surface.
struct WeldedMesh {
  // filled by weld: vertices and triangles
  std::vector<int32_t> welded_of;  ///< welded vertex of each surface vertex, -1 where none uses it
  Array<double> vertices;          ///< [m], (welded, 3): the first surface vertex of each
  Array<int32_t> triangles;        ///< welded vertices, (kept, 3), in the surface's order
  std::vector<int64_t> source;     ///< surface triangle of each kept one
  double tolerance = 0;            ///< the distance that was used [m]

  // filled by weld: counts
  int64_t unreferenced = 0;       ///< surface vertices that no triangle uses
  int64_t merged = 0;             ///< used surface vertices less welded ones
  int64_t zero_area = 0;          ///< triangles no higher than the tolerance, kept or not
  int64_t duplicate_faces = 0;    ///< left out because another one has the same vertices
  int64_t opposite_pairs = 0;     ///< sets of three vertices with as many faces each way
  int64_t border_edges = 0;       ///< with one face
  int64_t nonmanifold_edges = 0;  ///< with three faces or more
  int64_t turned_edges = 0;       ///< whose two faces run along them in one direction
  int64_t unbalanced_edges = 0;   ///< whose faces run more often in one direction than in the other
  int64_t pieces = 0;             ///< of triangles joined by edges
  double volume = 0;              ///< signed, about the box's centre [m^3]

  /// Every edge has two faces.
  bool closed() const { return triangles.rows() > 0 && border_edges + nonmanifold_edges == 0; }
  /// Faces run along every edge equally often in both directions: the winding number is an integer.
  bool balanced() const { return triangles.rows() > 0 && unbalanced_edges == 0; }
};

/// Joins vertices, drops degenerate triangles and copies, counts edges. A vertex joins the nearest
/// earlier one within the tolerance, so chains of close vertices do not collapse. Repeats to the
/// bit.
/// @param tolerance  share of the longest edge, see kWeldTolerance.
WeldedMesh weld(const Surface& surface, double tolerance = kWeldTolerance);

}  // namespace elastogen
