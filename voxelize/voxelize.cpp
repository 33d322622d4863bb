// SPDX-License-Identifier: Apache-2.0
#include "voxelize/voxelize.hpp"

#include "core/error.hpp"
#include "voxelize/bricks.hpp"
#include "voxelize/budget.hpp"
#include "voxelize/fill_fraction.hpp"
#include "voxelize/thin_features.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr double kFull = 1 - 1e-9;            // fill that counts as full
constexpr double kSomeFill = 1e-6;            // fill from which its own means are taken
constexpr double kNoVolume[2] = {1e-6, 0.1};  // mean fill of a surface around nothing: closed, open

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

/// The surface cells that become voxels, and how.
struct Border {
  std::vector<uint8_t> kept;   ///< (cells)
  std::vector<uint8_t> layer;  ///< 1: part of a sheet, a full voxel, (cells)
};

Array<int32_t> active_coords(const SurfaceCells& cells, const Border& border, const Fill& fill) {
  const int64_t kept = std::count(border.kept.begin(), border.kept.end(), 1);
  Array<int32_t> coords(kept + fill.full_voxels(), 3);
  int64_t v = 0;
  const auto add = [&](const Coord& c, int32_t shift) {
    coords(v, 0) = c[0] + shift;
    coords(v, 1) = c[1];
    coords(v, 2) = c[2];
    ++v;
  };
  for (int64_t c = 0; c < cells.count(); ++c)
    if (border.kept[c]) add(cells.coord[c], 0);
  for (const Run& run : fill.full)
    for (int32_t i = 0; i < run.length; ++i) add(run.first, i);
  return coords;
}

/// Cells that the surface only grazes belong to the voxel on the other side of the face in which
/// it lies; where there is none either, they are kept.
void keep_grazed(const SurfaceCells& cells, const LatticeMesh& mesh, const Fill& fill,
                 Border& border) {
  std::vector<int64_t> grazed;
  for (int64_t c = 0; c < cells.count(); ++c)
    if (!border.kept[c] && cells.side[c]) grazed.push_back(c);
  if (grazed.empty()) return;
  const BrickIndex index(active_coords(cells, border, fill));
  for (const int64_t c : grazed) {
    bool held = false;
    for (int side = 0; side < 6; ++side) {
      Coord other = cells.coord[c];
      other[side >> 1] += side & 1 ? 1 : -1;
      held |= (cells.side[c] >> side & 1) && index.find(other) >= 0;
    }
    if (held) continue;
    border.kept[c] = 1;
    border.layer[c] |= mesh.sheet[cells.triangle[cells.first[c]]];
  }
}

Border choose_border(const SurfaceCells& cells, const LatticeMesh& mesh, const Fill& fill,
                     bool all_sheets) {
  Border border;
  border.kept = cells.touched;
  border.layer.assign(cells.count(), all_sheets);
  for (int64_t c = 0; c < cells.count(); ++c) {
    border.kept[c] |= sum8(fill.moment.row(c)) > 0.5;
    border.layer[c] |= cells.sheet[c];
  }
  keep_grazed(cells, mesh, fill, border);
  return border;
}

/// Shape-function means of a voxel from the integrals over what fills it.
void set_means(const double* moment, double* means) {
  double sum = 0;
  for (int k = 0; k < 8; ++k) sum += means[k] = std::max(moment[k], 0.0);
  for (int k = 0; k < 8; ++k) means[k] = sum > 0 ? means[k] / sum : 0.125;
}

/// Sets fill and means of the border voxels; counts them.
void fill_border(const SurfaceCells& cells, const Border& border, const Fill& fill,
                 Voxelized& result) {
  const BrickIndex index(result.grid.voxel_coord);
  for (int64_t c = 0; c < cells.count(); ++c) {
    if (!border.kept[c]) continue;
    ++result.report.border_voxels;
    const double share = sum8(fill.moment.row(c));
    if (border.layer[c] || share > kFull) continue;
    const int64_t v = index.find(cells.coord[c]);
    result.report.thin_voxels += share < kMinFill;
    result.grid.fill(v) = std::max(share, kMinFill);
    set_means(share > kSomeFill ? fill.moment.row(c) : cells.area.row(c),
              result.grid.shape_mean.row(v));
  }
}

/// Volume in voxels: what the surface bounds, and a full voxel for each of a sheet's.
double total_volume(const SurfaceCells& cells, const Border& border, const Fill& fill) {
  double volume = fill.volume;
  for (int64_t c = 0; c < cells.count(); ++c)
    if (border.kept[c] && border.layer[c]) volume += 1 - sum8(fill.moment.row(c));
  return volume;
}

void add_findings(const LatticeMesh& mesh, bool all_sheets, VoxelizeReport& report) {
  const auto add = [&](const char* what, int64_t count, const std::string& text) {
    if (count > 0) report.findings.push_back({what, count, text});
  };
  const auto triangles = static_cast<int64_t>(mesh.triangles.size());
  const int64_t sheets = all_sheets ? triangles : mesh.sheets;
  add("turned-faces", mesh.turned,
      concat(mesh.turned, " of ", triangles, " faces were turned to agree with their neighbours"));
  add("sheet", sheets,
      concat(sheets, " of ", triangles,
             " faces bound no solid; they became layers one voxel thick"));
  add("winding-number", report.winding_number,
      "the surface has holes, overlaps or faces wound both ways; its inside was found by the "
      "winding number");
}

/// Says in the report how it was found, and whether the surface bounds nothing.
Fill find_fill(const LatticeMesh& mesh, const SurfaceCells& cells, int64_t max_voxels,
               bool& all_sheets, VoxelizeReport& report) {
  std::optional<Fill> fill = exact_fill(cells, 1);
  if (!fill) fill = exact_fill(cells, -1);
  const bool exact = fill.has_value();
  if (!exact) fill = winding_fill(mesh, cells, max_voxels);
  all_sheets = fill->full.empty() &&
               fill->volume < kNoVolume[!report.closed] * static_cast<double>(cells.count());
  report.winding_number = !exact && !all_sheets;
  return std::move(*fill);
}

}  // namespace

Voxelized voxelize(const Surface& surface, const VoxelizeOptions& options) {
  check(surface);
  const WeldedMesh welded = weld(surface);
  ELASTOGEN_CHECK_ASSET(welded.triangles.rows() > 0,
                        "no triangle has an area: nothing to simulate");
  Box box;
  for (int64_t v = 0; v < welded.vertices.rows(); ++v)
    box.add({welded.vertices(v, 0), welded.vertices(v, 1), welded.vertices(v, 2)});
  const Lattice lattice = choose_lattice(box, options);
  check_budget(welded, lattice.h, options);

  // surface, inside, border
  const LatticeMesh mesh = make_lattice_mesh(welded, lattice);
  const SurfaceCells cells = cut_surface(mesh);
  Voxelized result;
  result.report.closed = welded.closed();
  bool all_sheets = false;
  const Fill fill = find_fill(mesh, cells, options.max_voxels, all_sheets, result.report);
  const Border border = choose_border(cells, mesh, fill, all_sheets);

  // grid
  const Array<int32_t> coords = active_coords(cells, border, fill);
  check_budget(coords.rows(), lattice.h, options);
  result.grid = make_grid(coords, lattice.h, lattice.origin);
  fill_border(cells, border, fill, result);
  const double cube = lattice.h * lattice.h * lattice.h;
  result.grid.volume = all_sheets ? 0 : cube * total_volume(cells, border, fill);
  for (int64_t v = 0; v < result.grid.voxel_count(); ++v)
    result.report.volume += cube * result.grid.fill(v);
  add_findings(mesh, all_sheets, result.report);
  for (Finding& finding : check_grid(result.grid))
    result.report.findings.push_back(std::move(finding));
  return result;
}

}  // namespace elastogen
