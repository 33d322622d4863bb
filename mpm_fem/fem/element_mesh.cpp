// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/element_mesh.hpp"

#include "core/error.hpp"
#include "core/mat3.hpp"
#include "mpm_fem/fem/shape_functions.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <string>
#include <utility>

namespace elastogen::fem {
namespace {

constexpr std::array<std::pair<Element, std::string_view>, 7> kElements = {{
    {Element::kVoxel, "voxel"},
    {Element::kHex, "hex"},
    {Element::kHexBbar, "hex-bbar"},
    {Element::kTet4, "tet4"},
    {Element::kTet10, "tet10"},
    {Element::kTet10Bbar, "tet10-bbar"},
    {Element::kTri3, "tri3"},
}};

/// @throws Error naming the first entry outside [lower, upper] (NaN is outside).
template <class T>
void check_range(const Array<T>& array, double lower, double upper, const char* name) {
  for (int64_t k = 0; k < array.size(); ++k) {
    const auto value = double(array.data()[k]);
    ELASTOGEN_CHECK(value >= lower && value <= upper, name, '(', k / array.cols(), ", ",
                    k % array.cols(), ") must lie in [", lower, ", ", upper, "], got ", value);
  }
}

void check_tables(const ElementMesh& mesh) {
  const int nodes = nodes_of(mesh.element);
  ELASTOGEN_CHECK(mesh.elements.rows() > 0, "the mesh has no elements");
  ELASTOGEN_CHECK(mesh.rest.cols() == 3, "rest must be (nodes, 3)");
  ELASTOGEN_CHECK(mesh.elements.cols() == nodes, "elements must be (elements, ", nodes, ") for ",
                  element_name(mesh.element), ", got ", mesh.elements.cols(), " columns");
  const int64_t elements = mesh.elements.rows();
  ELASTOGEN_CHECK(In<double>(mesh.fill).size() == 0 || In<double>(mesh.fill).is(elements, 1),
                  "fill must be (elements, 1) or empty");
  ELASTOGEN_CHECK(mesh.material.rows() == elements && mesh.material.cols() == 1,
                  "material must be (elements, 1)");
  ELASTOGEN_CHECK(mesh.element != Element::kVoxel || is_voxel_mesh(mesh),
                  "a mesh of voxels needs their fill");
  check_range(mesh.rest, -std::numeric_limits<double>::max(), std::numeric_limits<double>::max(),
              "rest");
  check_range(mesh.elements, 0, double(mesh.rest.rows() - 1), "elements");
  check_range(mesh.fill, std::numeric_limits<double>::min(), std::numeric_limits<double>::max(),
              "fill");
  // boxes, or maps
  const int columns = nodes == 8 ? 6 : 12;
  ELASTOGEN_CHECK(
      In<double>(mesh.part).size() == 0 ||
          (In<double>(mesh.part).is(elements, columns) && !is_plane(mesh.element)),
      "part must be (elements, 6) of hexahedra, (elements, 12) of tetrahedra, or empty");
  if (nodes == 8) check_range(mesh.part, 0, 1, "part");
}

/// @throws Error unless all triangles lie in one plane z.
void check_plane(const ElementMesh& mesh) {
  for (int64_t n = 0; n < mesh.rest.rows(); ++n)
    ELASTOGEN_CHECK(mesh.rest(n, 2) == mesh.rest(0, 2), "node ", n,
                    " of plane triangles has z = ", mesh.rest(n, 2), " m, the first ",
                    mesh.rest(0, 2), " m");
}

/// @throws Error unless the nodes form a cube up to 1e-3 h, more than positions are rounded by.
void check_cube(const ElementMesh& mesh, int64_t element) {
  for (int c = 0; c < 8; ++c)
    for (int d = 0; d < 3; ++d) {
      const double edge =
          mesh.rest(mesh.elements(element, c), d) - mesh.rest(mesh.elements(element, 0), d);
      ELASTOGEN_CHECK(std::abs(edge - (c >> d & 1) * mesh.h) <= 1e-3 * mesh.h, "element ", element,
                      " must be a cube of edge ", mesh.h, ", its corner ", c, " lies ", edge,
                      " from the first along axis ", d);
    }
}

void check_voxels(const ElementMesh& mesh) {
  constexpr double kLargest = std::numeric_limits<double>::max();
  const int64_t elements = mesh.elements.rows();
  ELASTOGEN_CHECK(mesh.h > 0 && std::isfinite(mesh.h), "h must be positive, got ", mesh.h);
  ELASTOGEN_CHECK(In<double>(mesh.shape_mean).is(elements, 8), "shape_mean must be (elements, 8)");
  ELASTOGEN_CHECK(In<double>(mesh.variance).is(elements, 4), "variance must be (elements, 4)");
  check_range(mesh.shape_mean, -kLargest, kLargest, "shape_mean");
  check_range(mesh.variance, 0, kLargest, "variance");
  for (int64_t e = 0; e < elements; ++e) check_cube(mesh, e);
}

void check_jacobian(const ElementMesh& mesh, int64_t element) {
  double X[kMaxDofs], dN[kMaxDofs];
  element_nodes(mesh, element, X);
  for (const QuadraturePoint& point : potential_rule(mesh.element)) {
    Mat3<double> J;
    shape_gradients(mesh.element, point.xi, dN);
    jacobian(mesh.element, X, dN, J.m);
    const double value = determinant(J);
    ELASTOGEN_CHECK(value > 0 && std::isfinite(value), "element ", element,
                    " must have a positive Jacobian, got ", value, " m^3 at (", point.xi[0], ", ",
                    point.xi[1], ", ", point.xi[2], ")");
  }
}

}  // namespace

std::string_view element_name(Element element) {
  for (const auto& [known, name] : kElements)
    if (known == element) return name;
  return "unknown";
}

Element element_from_name(std::string_view name) {
  std::string known;
  for (const auto& [element, text] : kElements) {
    if (text == name) return element;
    known += (known.empty() ? "" : ", ") + std::string(text);
  }
  throw Error(concat("unknown element '", name, "'; known are ", known));
}

int nodes_of(Element element) {
  switch (element) {
    case Element::kTet4:
      return 4;
    case Element::kTet10:
    case Element::kTet10Bbar:
      return 10;
    case Element::kTri3:
      return 3;
    default:
      return 8;
  }
}

/// The box in the unit cube that has a voxel's centroid and meets faces of it, along one axis.
void part_along(const double* shape_mean, int axis, double* lower, double* upper) {
  double centre = 0;
  for (int c = 0; c < 8; ++c) centre += shape_mean[c] * (c >> axis & 1);
  *lower = std::clamp(2 * centre - 1, 0.0, 1.0);
  *upper = std::clamp(2 * centre, 0.0, 1.0);
}

/// Parts of the voxels at dependent nodes; the others are whole.
Array<double> free_parts(const Scene& scene) {
  const VoxelGrid& grid = scene.grid;
  Array<double> part(grid.voxel_count(), 6);
  for (int64_t v = 0; v < part.rows(); ++v) {
    bool follows = false;
    for (int c = 0; c < 8; ++c) follows |= scene.pinned(grid.corners(v, c)) == kDependentNode;
    for (int d = 0; d < 3; ++d) {
      part(v, 3 + d) = 1;
      if (follows) part_along(grid.shape_mean.row(v), d, &part(v, d), &part(v, 3 + d));
    }
  }
  return part;
}

ElementMesh voxel_mesh(const Scene& scene, Element element) {
  ELASTOGEN_CHECK(nodes_of(element) == 8, "voxels are no elements of kind ", element_name(element));
  const VoxelGrid& grid = scene.grid;
  ELASTOGEN_CHECK(In<double>(scene.variance).is(grid.voxel_count(), 4),
                  "voxel_mesh needs a finished scene");
  ElementMesh mesh;
  mesh.element = element;
  mesh.rest = grid.rest;
  mesh.elements = grid.corners;
  mesh.material = scene.material;
  mesh.h = grid.h;
  mesh.fill = grid.fill;
  mesh.shape_mean = grid.shape_mean;
  mesh.variance = scene.variance;
  mesh.hourglass = scene.hourglass;
  if (element != Element::kVoxel && !scene.dependent.empty()) mesh.part = free_parts(scene);
  return mesh;
}

double element_edge(const ElementMesh& mesh, double volume) {
  const double mean = volume / double(std::max<int64_t>(1, mesh.elements.rows()));
  return is_plane(mesh.element) ? std::sqrt(mean) : std::cbrt(mean);
}

void element_nodes(const ElementMesh& mesh, int64_t element, double* X) {
  const int32_t* nodes = mesh.elements.row(element);
  for (int a = 0; a < nodes_of(mesh.element); ++a)
    for (int d = 0; d < 3; ++d)
      X[3 * a + d] = is_voxel_mesh(mesh) ? (a >> d & 1) * mesh.h
                                         : mesh.rest(nodes[a], d) - mesh.rest(nodes[0], d);
}

void check_mesh(const ElementMesh& mesh) {
  check_tables(mesh);
  if (is_voxel_mesh(mesh)) return check_voxels(mesh);
  if (is_plane(mesh.element)) check_plane(mesh);
  for (int64_t e = 0; e < mesh.elements.rows(); ++e) check_jacobian(mesh, e);
}

}  // namespace elastogen::fem
