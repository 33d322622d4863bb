// SPDX-License-Identifier: Apache-2.0
#include "voxelize/voxelize.hpp"

#include "core/error.hpp"
#include "voxelize/bricks.hpp"
#include "voxelize/budget.hpp"
#include "voxelize/cut_body.hpp"
#include "voxelize/thin_features.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr double kFull = 1 - 1e-9;  // fill that counts as full
constexpr double kSomeFill = 1e-6;  // fill from which its own means are taken

/// Shape-function means of a voxel from the integrals over what fills it.
void set_means(const double* moment, double* means) {
  double sum = 0;
  for (int k = 0; k < 8; ++k) sum += means[k] = std::max(moment[k], 0.0);
  for (int k = 0; k < 8; ++k) means[k] = sum > 0 ? means[k] / sum : 0.125;
}

/// Sets fill and means of the border voxels; counts them.
void fill_border(const CutBody& body, Voxelized& result) {
  const BrickIndex index(result.grid.voxel_coord);
  for (int64_t c = 0; c < body.cells.count(); ++c) {
    if (!body.kept[c]) continue;
    ++result.report.border_voxels;
    const double share = body.share(c);
    if (share > kFull) continue;
    const int64_t v = index.find(body.cells.coord[c]);
    result.report.thin_voxels += share < kMinFill;
    result.grid.fill(v) = std::max(share, kMinFill);
    set_means(share > kSomeFill ? body.fill.moment.row(c) : body.cells.area.row(c),
              result.grid.shape_mean.row(v));
  }
}

/// Volume in voxels: what the surface bounds, and a full voxel for each of a sheet's.
double total_volume(const CutBody& body) {
  double volume = body.fill.volume;
  for (int64_t c = 0; c < body.cells.count(); ++c) {
    if (!body.kept[c] || !body.layer[c]) continue;
    volume += 1;
    for (int k = 0; k < 8; ++k) volume -= body.fill.moment(c, k);
  }
  return volume;
}

void add_findings(const CutBody& body, VoxelizeReport& report) {
  const auto add = [&](const char* what, int64_t count, const std::string& text) {
    if (count > 0) report.findings.push_back({what, count, text});
  };
  const auto triangles = static_cast<int64_t>(body.mesh.triangles.size());
  const int64_t turned = body.mesh.turned;
  const int64_t sheets = body.all_sheets ? triangles : body.mesh.sheets;
  add("turned-faces", turned,
      concat("of ", triangles, " faces do not agree with their neighbours"));
  add("sheet", sheets, concat("of ", triangles, " faces bound no solid"));
  add("winding-number", report.winding_number,
      "the surface has holes, overlaps or faces wound both ways");
}

}  // namespace

Voxelized voxelize(const Surface& surface, const VoxelizeOptions& options) {
  CutBody body = cut_body(surface, options);
  Voxelized result;
  VoxelizeReport& report = result.report;
  report.closed = body.closed;
  report.winding_number = body.winding_number;
  report.dropped_slivers = drop_slivers(body);

  const double h = body.lattice.h, cube = h * h * h;
  const Array<int32_t> coords = body.voxels();
  check_budget(coords.rows(), h, options);
  result.grid = make_grid(coords, h, body.lattice.origin);
  fill_border(body, result);
  result.grid.volume = body.all_sheets ? 0 : cube * total_volume(body);
  for (int64_t v = 0; v < result.grid.voxel_count(); ++v)
    report.volume += cube * result.grid.fill(v);
  add_findings(body, report);
  for (Finding& finding : check_grid(result.grid)) report.findings.push_back(std::move(finding));
  return result;
}

}  // namespace elastogen
