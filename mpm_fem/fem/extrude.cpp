// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/extrude.hpp"

#include "core/error.hpp"
#include "mpm_fem/fem/voxel_tets.hpp"

#include <cmath>
#include <limits>

namespace elastogen::fem {
namespace {

/// Numbers of cells of a lattice along x, y, z; nodes have x fastest.
struct Lattice {
  int64_t nx, ny, nz;

  int64_t node(int64_t i, int64_t j, int64_t k) const { return i + (nx + 1) * (j + (ny + 1) * k); }
  int64_t node_count() const { return node(nx, ny, nz) + 1; }
};

Lattice checked_lattice(int64_t nx, int64_t ny, int64_t nz) {
  ELASTOGEN_CHECK(nx >= 1 && ny >= 1 && nz >= 1,
                  "at least one cell along each axis is expected, got ", nx, " x ", ny, " x ", nz);
  const double nodes = (nx + 1.) * (ny + 1.) * (nz + 1.);
  ELASTOGEN_CHECK(nodes <= std::numeric_limits<int32_t>::max(), nx, " x ", ny, " x ", nz,
                  " cells have more nodes than 32 bits count");
  return {nx, ny, nz};
}

/// A lattice of hexahedra with its nodes at place(i, j, k).
template <class Place>
ElementMesh lattice_mesh(const Lattice& lattice, const Place& place) {
  const auto [nx, ny, nz] = lattice;
  ElementMesh mesh;
  mesh.element = Element::kHex;
  mesh.rest = Array<double>(lattice.node_count(), 3);
  mesh.elements = Array<int32_t>(nx * ny * nz, 8);
  mesh.material = Array<int32_t>(nx * ny * nz);
  for (int64_t k = 0; k <= nz; ++k)
    for (int64_t j = 0; j <= ny; ++j)
      for (int64_t i = 0; i <= nx; ++i) {
        const Vec3 x = place(i, j, k);
        for (int d = 0; d < 3; ++d) mesh.rest(lattice.node(i, j, k), d) = x[size_t(d)];
      }
  for (int64_t k = 0; k < nz; ++k)
    for (int64_t j = 0; j < ny; ++j)
      for (int64_t i = 0; i < nx; ++i)
        for (int c = 0; c < 8; ++c)
          mesh.elements(i + nx * (j + ny * k), c) =
              int32_t(lattice.node(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2)));
  return mesh;
}

ElementMesh cut_into_tets(ElementMesh mesh) {
  mesh.element = Element::kTet4;
  mesh.elements = kuhn_tets(mesh.elements);
  mesh.material = Array<int32_t>(mesh.elements.rows());
  return mesh;
}

void check_planes(const std::vector<double>& planes, char axis) {
  for (size_t k = 0; k < planes.size(); ++k)
    ELASTOGEN_CHECK(std::isfinite(planes[k]) && (k == 0 || planes[k] > planes[k - 1]), "plane ", k,
                    " of axis ", axis, " must be finite and above the one before, got ", planes[k]);
}

void check_convex(const std::array<Vec2, 4>& corners) {
  for (size_t c = 0; c < 4; ++c) {
    const Vec2 &p = corners[c], &q = corners[(c + 1) % 4], &r = corners[(c + 2) % 4];
    const double turn = (q[0] - p[0]) * (r[1] - q[1]) - (q[1] - p[1]) * (r[0] - q[0]);
    ELASTOGEN_CHECK(turn > 0 && std::isfinite(turn),
                    "a convex quadrilateral, counterclockwise, is expected; at corner ",
                    (c + 1) % 4, " it turns the other way");
  }
}

}  // namespace

std::vector<double> graded(int cells, double lower, double upper, double ratio) {
  ELASTOGEN_CHECK(cells >= 1 && lower < upper && std::isfinite(upper - lower) && ratio > 0 &&
                      std::isfinite(ratio),
                  "at least one cell, lower < upper and a positive ratio are expected, got ", cells,
                  " cells from ", lower, " to ", upper, ", ratio ", ratio);
  // share of the first k cells: (q^k - 1)/(q^n - 1) with the growth q from cell to cell
  const double growth = cells > 1 ? std::log(ratio) / (cells - 1) : 0;
  std::vector<double> planes;
  for (int k = 0; k < cells; ++k) {
    const double share =
        growth == 0 ? double(k) / cells : std::expm1(growth * k) / std::expm1(growth * cells);
    planes.push_back(lower + (upper - lower) * share);
  }
  planes.push_back(upper);
  return planes;
}

ElementMesh box_tets(const std::vector<double>& x, const std::vector<double>& y,
                     const std::vector<double>& z) {
  const Lattice lattice =
      checked_lattice(int64_t(x.size()) - 1, int64_t(y.size()) - 1, int64_t(z.size()) - 1);
  check_planes(x, 'x');
  check_planes(y, 'y');
  check_planes(z, 'z');
  return cut_into_tets(lattice_mesh(lattice, [&](int64_t i, int64_t j, int64_t k) {
    return Vec3{x[size_t(i)], y[size_t(j)], z[size_t(k)]};
  }));
}

ElementMesh box_tets(int nx, int ny, int nz, const Vec3& lower, const Vec3& upper) {
  return box_tets(graded(nx, lower[0], upper[0]), graded(ny, lower[1], upper[1]),
                  graded(nz, lower[2], upper[2]));
}

ElementMesh extruded_quadrilateral(const std::array<Vec2, 4>& corners, double thickness, int nx,
                                   int ny, int nz, Element element) {
  const Lattice lattice = checked_lattice(nx, ny, nz);
  check_convex(corners);
  ELASTOGEN_CHECK(thickness > 0 && std::isfinite(thickness), "the thickness must be positive, got ",
                  thickness);
  ELASTOGEN_CHECK(element != Element::kVoxel, "voxels are cubes; extrude hexahedra or tetrahedra");
  ElementMesh mesh = lattice_mesh(lattice, [&](int64_t i, int64_t j, int64_t k) {
    const double s = double(i) / nx, t = double(j) / ny;
    Vec3 x = {0, 0, thickness * (double(k) / nz)};
    for (size_t d = 0; d < 2; ++d)
      x[d] = (1 - t) * ((1 - s) * corners[0][d] + s * corners[1][d]) +
             t * ((1 - s) * corners[3][d] + s * corners[2][d]);
    return x;
  });
  if (element != Element::kHex && element != Element::kHexBbar) {
    mesh = cut_into_tets(std::move(mesh));
    if (element != Element::kTet4) mesh = quadratic(mesh);
  }
  mesh.element = element;
  return mesh;
}

}  // namespace elastogen::fem
