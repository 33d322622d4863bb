// SPDX-License-Identifier: Apache-2.0
#include "voxelize/cut_body.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "voxelize/budget.hpp"
#include "voxelize/sheets.hpp"
#include "voxelize/slivers.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

/// Thickest layer [voxel edges]. A tilted sheet has an area of up to sqrt(3) in a voxel, which must
/// hold its volume.
constexpr double kThickestLayer = 0.5;
constexpr double kNoVolume[2] = {1e-6, 0.1};  // mean fill of surfaces around no solid: closed, open

void check(const Surface& surface) {
  ELASTOGEN_CHECK(surface.vertices.cols() == 3, "vertices must be (vertices, 3)");
  ELASTOGEN_CHECK(surface.triangles.cols() == 3, "triangles must be (triangles, 3)");
  for (int64_t i = 0; i < surface.triangles.size(); ++i)
    ELASTOGEN_CHECK(
        surface.triangles.data()[i] >= 0 && surface.triangles.data()[i] < surface.vertices.rows(),
        "triangle ", i / 3, " has no vertex ", surface.triangles.data()[i]);
  for (int64_t i = 0; i < surface.vertices.size(); ++i)
    ELASTOGEN_CHECK_ASSET(std::isfinite(surface.vertices.data()[i]), "vertex ", i / 3,
                          " is not finite");
}

double sum8(const double* row) {
  double sum = 0;
  for (int k = 0; k < 8; ++k) sum += row[k];
  return sum;
}

/// A cell that the surface only grazes is left to the voxel beyond the face in which the surface
/// lies. If that voxel is not kept either, the cell is kept.
void keep_grazed(CutBody& body) {
  const SurfaceCells& cells = body.cells;
  std::vector<int64_t> grazed;
  for (int64_t c = 0; c < cells.count(); ++c)
    if (!body.kept[c] && cells.side[c]) grazed.push_back(c);
  if (grazed.empty()) return;
  const BrickIndex index(body.voxels());
  for (const int64_t c : grazed) {
    bool held = false;
    for (int side = 0; side < 6; ++side) {
      Coord other = cells.coord[c];
      other[side >> 1] += side & 1 ? 1 : -1;
      held |= (cells.side[c] >> side & 1) && index.find(other) >= 0;
    }
    if (held) continue;
    body.kept[c] = 1;
    body.layer[c] |= body.mesh.role[cells.triangle[cells.first[c]]] == Role::kSheet;
  }
}

void choose_voxels(CutBody& body) {
  const SurfaceCells& cells = body.cells;
  body.kept = cells.touched;
  body.layer.assign(cells.count(), body.all_sheets);
  for (int64_t c = 0; c < cells.count(); ++c) {
    body.kept[c] |= sum8(body.fill.moment.row(c)) > 0.5;
    body.layer[c] |= cells.sheet[c];
  }
  keep_grazed(body);
}

/// Fills the inside; records how it was found, and whether the surface bounds nothing.
void find_fill(CutBody& body, int64_t max_voxels) {
  const SurfaceCells& cells = body.cells;
  const auto is_empty = [&](const Fill& fill) {
    return fill.full.empty() &&
           fill.volume < kNoVolume[!body.closed] * static_cast<double>(cells.count());
  };
  std::optional<Fill> fill = exact_fill(cells, 1);
  if (!fill) fill = exact_fill(cells, -1);
  // rows along x do not see an open surface that lies along them
  const bool exact = fill && (body.closed || !is_empty(*fill));
  body.fill = exact ? std::move(*fill) : winding_fill(body.mesh, cells, max_voxels);
  body.all_sheets = is_empty(body.fill);
  body.winding_number = !exact && !body.all_sheets;
}

/// Makes a prism of a triangle of a sheet. Its upper face replaces the triangle.
void make_prism(CutBody& body, size_t t) {
  LatticeMesh& mesh = body.mesh;
  const Coord corner = mesh.triangles[t];
  const Vec3 area = area_vector(mesh, t);
  const Vec3 half = scaled(area, body.thickness / (2 * norm(area)));
  const auto first = int32_t(mesh.vertices.size());  // three vertices above, three below
  for (const double side : {1.0, -1.0})
    for (const int32_t v : corner)
      mesh.vertices.push_back(plus(mesh.vertices[size_t(v)], scaled(half, side)));
  const auto add = [&](int32_t a, int32_t b, int32_t c) {
    mesh.triangles.push_back({first + a, first + b, first + c});
    body.prism_of.push_back(int32_t(t));
  };
  mesh.triangles[t] = {first, first + 1, first + 2};
  add(3, 5, 4);
  for (int32_t k = 0; k < 3; ++k) {
    const int32_t next = (k + 1) % 3;
    add(k, k + 3, next + 3);
    add(k, next + 3, next);
  }
}

/// Makes prisms of sheets that are thicker than a layer. In a flat sheet neighbouring prisms share
/// their sides, so that the total volume is area times thickness.
void thicken(CutBody& body) {
  std::vector<Role>& role = body.mesh.role;
  for (size_t t = 0; t < role.size(); ++t) {
    if (role[t] != Role::kSheet) continue;
    role[t] = Role::kSolid;
    if (norm(area_vector(body.mesh, t)) > 0) make_prism(body, t);
  }
  role.resize(body.mesh.triangles.size(), Role::kSolid);
  if (!body.mesh.joint.empty()) body.mesh.joint.resize(role.size(), 0);
}

double area_of_sheets(const LatticeMesh& mesh) {
  double area = 0;
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    if (mesh.role[t] == Role::kSheet) area += norm(area_vector(mesh, t));
  return area;
}

}  // namespace

double CutBody::layer_volume(int64_t cell) const {
  if (!layer[cell]) return 0;
  const double empty_share = std::max(0.0, 1 - sum8(fill.moment.row(cell)));
  if (thickness == 0) return empty_share;
  const double area = all_sheets ? sum8(cells.area.row(cell)) : cells.sheet_area[cell];
  return std::min(empty_share, area * thickness);
}

double CutBody::share(int64_t cell) const {
  return sum8(fill.moment.row(cell)) + layer_volume(cell);
}

void CutBody::moments(int64_t cell, double* result) const {
  constexpr double kSomeFill = 1e-6;  // fill from which on the moments of the fill are used
  const double sheet = layer_volume(cell), area = sum8(cells.area.row(cell));
  const bool some = share(cell) > kSomeFill;
  for (int k = 0; k < 8; ++k) {
    result[k] = some ? fill.moment(cell, k) : cells.area(cell, k);
    if (some && sheet > 0) result[k] += area > 0 ? sheet * cells.area(cell, k) / area : sheet / 8;
  }
}

Array<int32_t> CutBody::voxels() const {
  Array<int32_t> coords(std::count(kept.begin(), kept.end(), 1) + fill.full_voxels(), 3);
  int64_t v = 0;
  const auto add = [&](const Coord& c, int32_t shift) {
    coords(v, 0) = c[0] + shift;
    coords(v, 1) = c[1];
    coords(v, 2) = c[2];
    ++v;
  };
  for (int64_t c = 0; c < cells.count(); ++c)
    if (kept[c]) add(cells.coord[c], 0);
  for (const Run& run : fill.full)
    for (int32_t i = 0; i < run.length; ++i) add(run.first, i);
  return coords;
}

CutBody cut_body(const Surface& surface, const VoxelizeOptions& options,
                 const std::optional<Lattice>& lattice) {
  // weld, choose the lattice, and stop before too many voxels
  check(surface);
  CutBody body;
  body.welded = weld(surface);
  const WeldedMesh& welded = body.welded;
  ELASTOGEN_CHECK_ASSET(welded.triangles.rows() > 0,
                        "no triangle has an area: nothing to simulate");
  Box box;
  for (int64_t v = 0; v < welded.vertices.rows(); ++v)
    box.add({welded.vertices(v, 0), welded.vertices(v, 1), welded.vertices(v, 2)});
  body.lattice = lattice ? *lattice : choose_lattice(box, options);
  check_budget(welded, body.lattice.h, options);
  // triangles on the lattice, solids wound consistently, sheets found
  body.closed = welded.closed();
  body.balanced = welded.balanced();
  body.mesh = make_lattice_mesh(welded, body.lattice);
  body.thickness = options.thickness / body.lattice.h;
  body.sheet_area = area_of_sheets(body.mesh);
  // sheets thicker than a layer become prisms before the surface is cut
  const bool thick = body.thickness > kThickestLayer;
  if (thick && body.mesh.sheets > 0) thicken(body);
  body.cells = cut_surface(body.mesh);
  find_fill(body, options.max_voxels);
  // a surface that bounds nothing is a sheet as a whole
  if (body.all_sheets) {
    std::ranges::fill(body.mesh.role, Role::kSheet);
    body.mesh.sheets = int64_t(body.mesh.triangles.size());
    body.sheet_area = area_of_sheets(body.mesh);
  }
  if (body.all_sheets && thick) {
    thicken(body);
    body.cells = cut_surface(body.mesh);
    find_fill(body, options.max_voxels);
  }
  choose_voxels(body);
  return body;
}

int64_t drop_slivers(CutBody& body, const std::vector<uint8_t>& stays) {
  const Array<int32_t> coords = body.voxels();
  Array<double> fill(coords.rows());
  fill.fill(1);
  std::vector<int64_t> cell;  // cell of each border voxel
  for (int64_t c = 0; c < body.cells.count(); ++c) {
    if (!body.kept[c]) continue;
    // layers hold together by their sheet, so they are never slivers, however thin
    const bool never = body.layer[c] || (!stays.empty() && stays[c]);
    fill(static_cast<int64_t>(cell.size())) = never ? 1 : body.share(c);
    cell.push_back(c);
  }
  const std::vector<uint8_t> slivers = find_slivers(coords, fill);
  for (size_t v = 0; v < cell.size(); ++v)
    if (slivers[v]) body.kept[cell[v]] = 0;
  return std::count(slivers.begin(), slivers.end(), 1);
}

}  // namespace elastogen
