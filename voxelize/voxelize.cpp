// SPDX-License-Identifier: Apache-2.0
#include "voxelize/voxelize.hpp"

#include "core/error.hpp"
#include "voxelize/apart.hpp"
#include "voxelize/bricks.hpp"
#include "voxelize/budget.hpp"
#include "voxelize/cut_body.hpp"
#include "voxelize/free_part.hpp"
#include "voxelize/thin_cuts.hpp"
#include "voxelize/thin_features.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr double kFull = 1 - 1e-9;  // fill that counts as full

/// Shape-function means of a voxel from integrals over its filled part.
void set_means(const double* moment, double* means) {
  double sum = 0;
  for (int k = 0; k < 8; ++k) sum += means[k] = std::max(moment[k], 0.0);
  for (int k = 0; k < 8; ++k) means[k] = sum > 0 ? means[k] / sum : 0.125;
}

/// Sets fill and means of the border voxels; counts them.
/// @param shift  shift of the body's voxels along x.
void fill_border(const CutBody& body, const BrickIndex& index, int32_t shift, Voxelized& result) {
  for (int64_t c = 0; c < body.cells.count(); ++c) {
    if (!body.kept[c]) continue;
    ++result.report.border_voxels;
    const double share = body.share(c);
    Coord at = body.cells.coord[c];
    at[0] += shift;
    const int64_t v = index.find(at);
    if (v < 0) continue;  // held
    if (!result.grid.sheet.empty() && body.layer[c]) result.grid.sheet(v) = body.thickness;
    if (share > kFull) continue;
    // the least fill of a sheet is that of a full layer of it
    const double least = kMinFill * (body.layer[c] && body.thickness > 0 ? body.thickness : 1);
    result.report.thin_voxels += share < least;
    result.grid.fill(v) = std::max(share, least);
    double moment[8];
    body.moments(c, moment);
    set_means(moment, result.grid.shape_mean.row(v));
  }
}

/// Fill and means of the voxels that borders cut; they have no least fill.
void fill_cut(const FreePart& free, const BrickIndex& index, int32_t shift, Voxelized& result) {
  for (const CutVoxel& cut : free.cut) {
    const auto v = int32_t(index.find({cut.coord[0] + shift, cut.coord[1], cut.coord[2]}));
    result.grid.fill(v) = cut.share;
    take_member(v, cut.thickness, result.grid);
    set_means(cut.moment, result.grid.shape_mean.row(v));
    for (const int32_t border : cut.borders) result.cut.push_back({v, border});
  }
}

/// The borders that the lattice of a body does not fit, by their number; others are empty boxes.
std::vector<Border> cutting_borders(const VoxelizeOptions& options, const Box& box,
                                    const Lattice& lattice) {
  std::vector<Border> borders = options.borders;
  bool any = false;
  for (Border& border : borders) {
    const bool cuts = !fits(border, box, lattice.h, lattice.origin);
    if (!cuts) border = {{1e300, 1e300, 1e300}, {-1e300, -1e300, -1e300}};
    any = any || cuts;
  }
  return any ? borders : std::vector<Border>{};
}

/// Volume of solids and layers [voxels].
double total_volume(const CutBody& body) {
  double volume = body.fill.volume;
  for (int64_t c = 0; c < body.cells.count(); ++c)
    if (body.kept[c]) volume += body.layer_volume(c);
  return volume;
}

/// Volume of the sheets [voxels].
double sheet_volume(const CutBody& body) {
  if (body.thickness > 0) return body.sheet_area * body.thickness;
  double volume = 0;
  for (int64_t c = 0; c < body.cells.count(); ++c)
    if (body.kept[c]) volume += body.layer_volume(c);
  return volume;
}

/// Facts about the whole surface that findings need.
struct Shape {
  int64_t turned, triangles;
  bool balanced;
};

void add_findings(const Shape& shape, const std::vector<CutBody>& bodies, VoxelizeReport& report) {
  const auto add = [&](const char* what, int64_t count, const std::string& text) {
    if (count > 0) report.findings.push_back({what, count, text});
  };
  int64_t sheets = 0;
  for (const CutBody& body : bodies) {
    sheets += body.mesh.sheets;
    report.winding_number |= body.winding_number;
  }
  add("turned-faces", shape.turned,
      concat("of ", shape.triangles, " faces do not agree with their neighbours"));
  add("sheet", sheets, concat("of ", shape.triangles, " faces bound no solid"));
  if (shape.balanced)
    add("overlaps", report.winding_number, "closed surfaces overlap, or some are inside out");
  else
    add("winding-number", report.winding_number, "the surface has holes or faces wound both ways");
}

/// The gaps between parts that the voxels of the whole close.
void take_gaps(const CutBody& whole, const Parts& parts, VoxelizeReport& report) {
  const auto source = [&](int32_t t) {
    return whole.welded.source[size_t(whole.welded_triangle(t))];
  };
  for (const PartGap& gap : parts.gaps)
    report.gaps.push_back(
        {{source(gap.triangle[0]), source(gap.triangle[1])}, gap.distance * whole.lattice.h});
}

/// The grid of several bodies; the voxels of body k are shifted by shift[k] along x.
void fill_grid(const std::vector<CutBody>& bodies, const std::vector<int32_t>& shift,
               const std::vector<Border>& borders, const VoxelizeOptions& options,
               Voxelized& result) {
  const double h = bodies[0].lattice.h, cube = h * h * h;
  // voxels with free material
  std::vector<int32_t> coords;
  std::vector<FreePart> free(bodies.size());
  for (size_t k = 0; k < bodies.size(); ++k) {
    if (!borders.empty()) free[k] = free_part(bodies[k], borders);
    Array<int32_t> some = borders.empty() ? bodies[k].voxels() : free[k].voxels;
    for (int64_t v = 0; v < some.rows(); ++v) some(v, 0) += shift[k];
    coords.insert(coords.end(), some.data(), some.data() + some.size());
  }
  const auto count = int64_t(coords.size() / 3);
  ELASTOGEN_CHECK(count > 0, "the pins hold all of the asset: there is nothing left to move");
  check_budget(count, h, options);
  result.grid = make_grid(In<int32_t>{coords.data(), count, 3}, h, bodies[0].lattice.origin);
  result.grid.volume = 0;
  if (options.thickness > 0) result.grid.sheet = Array<double>(count);
  // what they hold
  const BrickIndex index(result.grid.voxel_coord);
  for (size_t k = 0; k < bodies.size(); ++k) fill_border(bodies[k], index, shift[k], result);
  if (!borders.empty()) result.grid.member = Array<double>(count);
  for (size_t k = 0; k < bodies.size(); ++k) {
    result.report.sheet_volume += cube * sheet_volume(bodies[k]);
    fill_cut(free[k], index, shift[k], result);
    if (!bodies[k].all_sheets || bodies[k].thickness > 0)
      result.grid.volume += cube * (total_volume(bodies[k]) - free[k].held);
  }
  for (int64_t v = 0; v < result.grid.voxel_count(); ++v)
    result.report.volume += cube * result.grid.fill(v);
  std::ranges::sort(result.cut, {}, [](const BorderVoxel& at) {
    return std::pair{at.voxel, at.border};
  });
}

/// Gives a shell the requested thickness by scaling its fill; it cannot become thicker.
void thin_shell(const VoxelizeOptions& options, Voxelized& result) {
  VoxelizeReport& report = result.report;
  report.sheet_thickness = options.shell;
  if (options.thickness > 0 && options.thickness < options.shell) {
    report.sheet_thickness = options.thickness;
    const double share = options.thickness / options.shell;
    for (int64_t v = 0; v < result.grid.voxel_count(); ++v) {
      result.grid.fill(v) *= share;
      result.grid.sheet(v) = std::min(1.0, options.thickness / result.grid.h);
    }
    result.grid.volume *= share;
    report.volume *= share;
  }
  report.sheet_volume = result.grid.volume;
}

}  // namespace

Voxelized voxelize(const Surface& surface, const VoxelizeOptions& options) {
  Voxelized result;
  VoxelizeReport& report = result.report;
  // cut the surface, drop slivers, find parts
  CutBody whole = cut_body(surface, options);
  const std::vector<Border> borders = cutting_borders(options, surface.box, whole.lattice);
  report.dropped_slivers = drop_slivers(whole, cut_cells(whole, borders));
  report.closed = whole.closed;
  const Parts parts = find_parts(whole, options.part_pieces);
  const Shape shape = {whole.mesh.turned, whole.welded.triangles.rows(), whole.balanced};

  // bodies: each part by itself, or the whole with the gaps that its voxels close
  std::vector<CutBody> bodies;
  std::vector<int32_t> shift = {0};
  if (options.part_pieces && parts.count > 1) {
    bodies = cut_parts(whole, parts, options);
    report.dropped_slivers = 0;
    for (CutBody& body : bodies)
      report.dropped_slivers += drop_slivers(body, cut_cells(body, borders));
    shift = shifts_apart(bodies);
    result.part = part_of_triangles(surface, whole.welded, parts);
  } else {
    take_gaps(whole, parts, report);
    whole.welded = {};
    bodies.push_back(std::move(whole));
  }
  // one grid of all bodies
  fill_grid(bodies, shift, borders, options, result);
  if (report.sheet_volume > 0)
    report.sheet_thickness = options.thickness > 0 ? options.thickness : result.grid.h;
  if (options.shell > 0) thin_shell(options, result);
  if (bodies.size() > 1) set_parts(bodies, std::move(shift), result.grid);
  add_findings(shape, bodies, report);
  for (Finding& finding : check_grid(result.grid)) report.findings.push_back(std::move(finding));
  return result;
}

}  // namespace elastogen
