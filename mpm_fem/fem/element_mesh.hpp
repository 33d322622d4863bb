// SPDX-License-Identifier: Apache-2.0
// A body as finite elements of one kind.

#pragma once

#include "core/scene.hpp"

#include <string_view>

namespace elastogen::fem {

/// voxel: the network's own element, one deformation gradient (mean over the fill) with the
/// strain-variance term and the torsion correction. hex: trilinear, 2x2x2 Gauss points. tet4,
/// tet10: linear and quadratic tetrahedra, 1 and 4 points. bbar: with the mean dilatation of the
/// element. tri3: linear triangles in a plane z, 1 m thick, whose nodes stay in it: F_33 = 1.
enum class Element : uint8_t { kVoxel, kHex, kHexBbar, kTet4, kTet10, kTet10Bbar, kTri3 };

/// "voxel", "hex", "hex-bbar", "tet4", "tet10", "tet10-bbar", "tri3".
std::string_view element_name(Element element);
/// @throws Error (usage) naming the known elements.
Element element_from_name(std::string_view name);
/// 8, 4, 10 or 3.
int nodes_of(Element element);
/// Whether an element is plane.
inline bool is_plane(Element element) {
  return element == Element::kTri3;
}

/// Nodes of an element: hexahedra as VoxelGrid has them (corner c = i + 2 j + 4 k), tetrahedra with
/// det(x1 - x0, x2 - x0, x3 - x0) > 0, quadratic ones then the middles of the edges 01, 12, 02, 03,
/// 13, 23 (the order of VTK), triangles counterclockwise seen from +z.
struct ElementMesh {
  Element element = Element::kHex;
  Array<double> rest;       ///< position at rest [m], (nodes, 3)
  Array<int32_t> elements;  ///< node of each corner, (elements, nodes_of(element))
  Array<int32_t> material;  ///< index of each element's material, (elements, 1)

  /// Share of each element that is filled, a factor on its energy and mass, (elements, 1);
  /// empty: 1. Hexahedra that have it are voxels.
  Array<double> fill;
  /// Part of each reference element that its points lie in. Of hexahedra a box, lower and upper corner,
  /// (elements, 6); of tetrahedra the image of the reference one under xi = b + B xi_0, B row by row,
  /// then b, (elements, 12). Weights are those of the whole element. Empty: all of it.
  Array<double> part;

  // voxels only; filled by voxel_mesh
  double h = 0;              ///< edge [m]
  Array<double> shape_mean;  ///< means of the shape functions over the fill, (elements, 8)
  Array<double> variance;    ///< hourglass weights xy, yz, zx, xyz [Pa], (elements, 4)
  Hourglass hourglass = Hourglass::kFull;
};

/// The voxels of a finished scene as hexahedra on the same nodes.
/// @param element  kVoxel, kHex or kHexBbar; the energy of the last two is weighted with the fill, and
///                 at dependent nodes their points lie in the box that has its centroid and meets
///                 the faces of the voxel: the free part of one that a plane cuts.
ElementMesh voxel_mesh(const Scene& scene, Element element);

/// Whether the elements are the voxels of a grid, all of one shape.
inline bool is_voxel_mesh(const ElementMesh& mesh) {
  return nodes_of(mesh.element) == 8 && !mesh.fill.empty();
}

/// Mean edge [m] of elements with this volume in all: the root of their mean volume.
double element_edge(const ElementMesh& mesh, double volume);

/// Factor on energy and mass of an element.
inline double fill_of(const ElementMesh& mesh, int64_t element) {
  return mesh.fill.empty() ? 1 : mesh.fill(element);
}

/// A point of the reference element, moved with the whole element into its part.
inline Vec3 in_part(const ElementMesh& mesh, int64_t element, Vec3 xi) {
  if (mesh.part.empty()) return xi;
  const double* part = mesh.part.row(element);
  if (mesh.part.cols() == 12)
    return {part[9] + part[0] * xi[0] + part[1] * xi[1] + part[2] * xi[2],
            part[10] + part[3] * xi[0] + part[4] * xi[1] + part[5] * xi[2],
            part[11] + part[6] * xi[0] + part[7] * xi[1] + part[8] * xi[2]};
  for (size_t d = 0; d < 3; ++d) xi[d] = part[d] + xi[d] * (part[3 + d] - part[d]);
  return xi;
}

/// Nodes of an element relative to its first one [m], (nodes_of(element), 3); those of a voxel are
/// exact multiples of its edge, free of the rounding of positions far from the origin.
void element_nodes(const ElementMesh& mesh, int64_t element, double* X);

/// @throws Error naming the first place: tables that do not fit, an index out of range, a position
///         that is not finite, a voxel that is no cube of edge h or has a mean or weight out of
///         range, a fill out of range, triangles that do not lie in one plane z, an element whose
///         Jacobian is not positive at a quadrature point.
void check_mesh(const ElementMesh& mesh);

}  // namespace elastogen::fem
