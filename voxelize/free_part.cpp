// SPDX-License-Identifier: Apache-2.0
#include "voxelize/free_part.hpp"

#include "core/vec3.hpp"
#include "voxelize/held_share.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen {
namespace {

constexpr double kOnBorder =
    1e-7;  // borders are taken this much larger [voxel edges], so that one in
           // a face of the body or of a voxel holds what lies on it
constexpr double kNothing = 1e-9;  // free share of a voxel that is none
constexpr double kHeld = 1e-12;    // least share that counts as held
constexpr double kFlat = 1e-9;     // extent of a body that has none along an axis

/// Borders that meet a voxel, in its coordinates: 0..1 along each edge.
struct MetBorders {
  std::vector<int32_t> number;
  std::vector<Border> border;
  bool balls = false;
};

/// A border in lattice coordinates, larger by kOnBorder.
Border border_on_lattice(const Border& border, const Lattice& lattice) {
  Border result = border;
  result.radius = border.radius > 0 ? border.radius / lattice.h + kOnBorder : 0;
  const double margin = border.radius > 0 ? 0 : kOnBorder;
  for (size_t d = 0; d < 3; ++d) {
    result.lower[d] = (border.lower[d] - lattice.origin[d]) / lattice.h - margin;
    result.upper[d] = (border.upper[d] - lattice.origin[d]) / lattice.h + margin;
  }
  return result;
}

/// Whether a border meets the inside of a box.
bool meets(const Border& border, const Box& box) {
  if (border.radius > 0) {
    Vec3 nearest;
    for (size_t d = 0; d < 3; ++d)
      nearest[d] = std::clamp(border.lower[d], box.lower[d], box.upper[d]);
    return distance(border, nearest) < 0;
  }
  for (size_t d = 0; d < 3; ++d)
    if (border.lower[d] >= box.upper[d] || border.upper[d] <= box.lower[d]) return false;
  return true;
}

/// Cuts the voxels of one body.
class Cutter {
 public:
  Cutter(const CutBody& body, const std::vector<Border>& borders) : body_(body) {
    for (const Border& border : borders)
      borders_.push_back(border_on_lattice(border, body.lattice));
    for (const Vec3& vertex : body.mesh.vertices) box_.add(vertex);
  }

  /// Fills `cut` but for its coordinates from the integrals over what the body fills of a voxel.
  /// @param cell  of the surface, -1: the voxel has none.
  /// @return whether something is held.
  bool cut(const Coord& voxel, int64_t cell, const double of_body[8], CutVoxel& result) const {
    // the part of the voxel within the body's box, and the borders that meet it
    Box part;
    for (size_t d = 0; d < 3; ++d) {
      part.lower[d] = std::max(box_.lower[d] - voxel[d], 0.0);
      part.upper[d] = std::min(box_.upper[d] - voxel[d], 1.0);
      if (part.extent(int(d)) < kFlat) part.lower[d] = 0, part.upper[d] = 1;
    }
    const MetBorders met = borders_at(voxel, part);
    if (met.number.empty()) return false;
    // shares that they leave, of the box or of what the surface fills of it
    double free[8], body = 0;
    free_shares(part, met.border, free);
    if (cell >= 0)
      result.thickness = free_shares_inside(solid_triangles(body_.mesh, body_.cells, cell), of_body,
                                            part, met.border, free);
    result.share = 0;
    for (int c = 0; c < 8; ++c) {
      body += of_body[c];
      result.share += result.moment[c] = std::max(of_body[c], 0.0) * free[c];
    }
    result.borders = met.number;
    return met.balls || body - result.share > kHeld;
  }

 private:
  MetBorders borders_at(const Coord& voxel, const Box& part) const {
    MetBorders met;
    for (size_t b = 0; b < borders_.size(); ++b) {
      Border border = borders_[b];
      for (size_t d = 0; d < 3; ++d) border.lower[d] -= voxel[d], border.upper[d] -= voxel[d];
      if (!meets(border, part)) continue;
      met.number.push_back(int32_t(b));
      met.border.push_back(border);
      met.balls |= border.radius > 0;
    }
    return met;
  }

  const CutBody& body_;
  std::vector<Border> borders_;
  Box box_;
};

constexpr double kFullVoxel[8] = {0.125, 0.125, 0.125, 0.125, 0.125, 0.125, 0.125, 0.125};

/// Integrals of the shape functions over what a body fills of a cell.
void filled_moments(const CutBody& body, int64_t cell, double moment[8]) {
  body.moments(cell, moment);
  double sum = 0;
  for (int c = 0; c < 8; ++c) sum += moment[c] = std::max(moment[c], 0.0);
  const double share = body.share(cell);
  for (int c = 0; c < 8; ++c) moment[c] = sum > 0 ? moment[c] * share / sum : share / 8;
}

double sum_of(const double moment[8]) {
  double sum = 0;
  for (int c = 0; c < 8; ++c) sum += moment[c];
  return sum;
}

}  // namespace

FreePart free_part(const CutBody& body, const std::vector<Border>& borders) {
  const Cutter cutter(body, borders);
  FreePart result;
  std::vector<int32_t> kept;
  const auto add = [&](const Coord& at, int64_t cell, const double moment[8]) {
    CutVoxel cut;
    cut.coord = at;
    const bool is_cut = cutter.cut(at, cell, moment, cut);
    if (is_cut) result.held += sum_of(moment) - cut.share;
    if (is_cut && cut.share <= kNothing) return;
    kept.insert(kept.end(), at.begin(), at.end());
    if (is_cut) result.cut.push_back(std::move(cut));
  };
  // border voxels, then those without surface
  for (int64_t c = 0; c < body.cells.count(); ++c) {
    double moment[8];
    filled_moments(body, c, moment);
    CutVoxel dropped;
    if (!body.kept[size_t(c)]) {
      if (cutter.cut(body.cells.coord[size_t(c)], c, moment, dropped))
        result.held += sum_of(moment) - dropped.share;
      continue;
    }
    add(body.cells.coord[size_t(c)], c, moment);
  }
  for (const Run& run : body.fill.full)
    for (int32_t i = 0; i < run.length; ++i)
      add({run.first[0] + i, run.first[1], run.first[2]}, -1, kFullVoxel);
  result.voxels = Array<int32_t>(int64_t(kept.size() / 3), 3);
  std::copy(kept.begin(), kept.end(), result.voxels.data());
  return result;
}

std::vector<uint8_t> cut_cells(const CutBody& body, const std::vector<Border>& borders) {
  if (borders.empty()) return {};
  const Cutter cutter(body, borders);
  std::vector<uint8_t> result(size_t(body.cells.count()));
  for (int64_t c = 0; c < body.cells.count(); ++c) {
    if (!body.kept[size_t(c)]) continue;
    double moment[8];
    filled_moments(body, c, moment);
    CutVoxel cut;
    result[size_t(c)] =
        cutter.cut(body.cells.coord[size_t(c)], c, moment, cut) && cut.share > kNothing;
  }
  return result;
}

}  // namespace elastogen
