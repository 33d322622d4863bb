// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/surface_load.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace elastogen::fem {
namespace {

/// Corners of the faces; of a hexahedron side 2 d + s is that with bit d of the corners equal to s.
constexpr int kQuads[6][4] = {{0, 2, 4, 6}, {1, 3, 5, 7}, {0, 1, 4, 5},
                              {2, 3, 6, 7}, {0, 1, 2, 3}, {4, 5, 6, 7}};
constexpr int kTriangles[4][3] = {{1, 2, 3}, {0, 2, 3}, {0, 1, 3}, {0, 1, 2}};
constexpr int kMiddles[4][3] = {{5, 8, 9}, {6, 7, 9}, {4, 7, 8}, {4, 5, 6}};

struct Face {
  std::array<int32_t, 4> key;  ///< its nodes in ascending order, of triangles behind -1
  int64_t element;
  int side;
};

bool is_hexahedron(const ElementMesh& mesh) {
  return nodes_of(mesh.element) == 8;
}

/// Faces with one element whose corners are all selected, in the order of their nodes.
std::vector<Face> selected_faces(const ElementMesh& mesh, In<uint8_t> selected) {
  const bool hexahedron = is_hexahedron(mesh);
  const int sides = hexahedron ? 6 : 4, corners = hexahedron ? 4 : 3;
  std::vector<Face> faces;
  for (int64_t e = 0; e < mesh.elements.rows(); ++e)
    for (int side = 0; side < sides; ++side) {
      Face face{{-1, -1, -1, -1}, e, side};
      bool inside = true;
      for (int c = 0; c < corners; ++c) {
        face.key[size_t(c)] = mesh.elements(e, hexahedron ? kQuads[side][c] : kTriangles[side][c]);
        inside &= selected(face.key[size_t(c)]) != 0;
      }
      std::sort(face.key.begin(), face.key.end());
      if (inside) faces.push_back(face);
    }
  std::stable_sort(faces.begin(), faces.end(),
                   [](const Face& a, const Face& b) { return a.key < b.key; });
  std::vector<Face> outer;
  for (size_t k = 0; k < faces.size(); ++k) {
    const bool before = k > 0 && faces[k - 1].key == faces[k].key;
    const bool after = k + 1 < faces.size() && faces[k + 1].key == faces[k].key;
    if (!before && !after) outer.push_back(faces[k]);
  }
  return outer;
}

/// |(b - a) x (d - c)|/2 of four nodes [m^2].
double half_cross(const ElementMesh& mesh, int32_t a, int32_t b, int32_t c, int32_t d) {
  Vec3 p, q;
  for (int k = 0; k < 3; ++k) {
    p[size_t(k)] = mesh.rest(b, k) - mesh.rest(a, k);
    q[size_t(k)] = mesh.rest(d, k) - mesh.rest(c, k);
  }
  return std::hypot(p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2],
                    p[0] * q[1] - p[1] * q[0]) /
         2;
}

/// Adds the areas that the nodes of a quadrilateral stand for [m^2]; its diagonals cross.
void add_quad(const ElementMesh& mesh, const Face& face, Array<double>& area) {
  const int32_t* node = mesh.elements.row(face.element);
  const int* corner = kQuads[face.side];
  double size =
      half_cross(mesh, node[corner[0]], node[corner[3]], node[corner[1]], node[corner[2]]);
  if (is_voxel_mesh(mesh)) size *= mesh.fill(face.element);
  for (int c = 0; c < 4; ++c) {
    const int mirrored = corner[c] ^ (1 << face.side / 2);
    const double share =
        mesh.element == Element::kVoxel
            ? mesh.shape_mean(face.element, corner[c]) + mesh.shape_mean(face.element, mirrored)
            : 0.25;
    area(node[corner[c]]) += share * size;
  }
}

void add_triangle(const ElementMesh& mesh, const Face& face, Array<double>& area) {
  const int32_t* node = mesh.elements.row(face.element);
  const int* corner = kTriangles[face.side];
  const double size =
      half_cross(mesh, node[corner[0]], node[corner[1]], node[corner[0]], node[corner[2]]);
  const int* carrier = nodes_of(mesh.element) == 10 ? kMiddles[face.side] : corner;
  for (int c = 0; c < 3; ++c) area(node[carrier[c]]) += size / 3;
}

}  // namespace

Array<double> surface_load(const ElementMesh& mesh, In<uint8_t> selected, const Vec3& force) {
  const int64_t nodes = mesh.rest.rows();
  ELASTOGEN_CHECK(selected.rows == nodes && selected.cols == 1, "selected must be (", nodes,
                  ", 1), got (", selected.rows, ", ", selected.cols, ")");
  Array<double> area(nodes);
  for (const Face& face : selected_faces(mesh, selected)) {
    if (is_hexahedron(mesh))
      add_quad(mesh, face, area);
    else
      add_triangle(mesh, face, area);
  }
  double total = 0;
  for (int64_t n = 0; n < nodes; ++n) total += area(n);
  if (total == 0) return {};
  Array<double> load(nodes, 3);
  for (int64_t n = 0; n < nodes; ++n)
    for (int d = 0; d < 3; ++d) load(n, d) = force[size_t(d)] * (area(n) / total);
  return load;
}

}  // namespace elastogen::fem
