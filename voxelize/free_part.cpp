// SPDX-License-Identifier: Apache-2.0
#include "voxelize/free_part.hpp"

#include "core/vec3.hpp"

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
constexpr int kLattice = 8;        // points along an edge
constexpr size_t kMostBoxes = 6;   // boxes in a voxel whose union is found exactly

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

/// Integrals of the shape functions over a box within a voxel, 0 if it is empty.
void box_moments(const Box& box, double moment[8]) {
  double line[3][2];
  for (size_t d = 0; d < 3; ++d) {
    const double a = box.lower[d], b = std::max(box.upper[d], a), half = (b * b - a * a) / 2;
    line[d][0] = b - a - half;
    line[d][1] = half;
  }
  for (int c = 0; c < 8; ++c) moment[c] = line[0][c & 1] * line[1][c >> 1 & 1] * line[2][c >> 2];
}

/// Integrals over the part of a box within a voxel that lies in the union of boxes, by the sums over
/// the intersections of each set of them.
void union_of_boxes(const Box& box, const std::vector<Border>& boxes, double held[8]) {
  std::fill_n(held, 8, 0.0);
  for (uint32_t set = 1; set < 1u << boxes.size(); ++set) {
    Box common = box;
    double sign = -1;
    for (size_t b = 0; b < boxes.size(); ++b) {
      if (!(set >> b & 1)) continue;
      sign = -sign;
      for (size_t d = 0; d < 3; ++d) {
        common.lower[d] = std::max(common.lower[d], boxes[b].lower[d]);
        common.upper[d] = std::min(common.upper[d], boxes[b].upper[d]);
      }
    }
    double moment[8];
    box_moments(common, moment);
    for (int c = 0; c < 8; ++c) held[c] += sign * moment[c];
  }
}

/// The same for any borders, as means over points.
void union_of_borders(const Box& box, const std::vector<Border>& borders, double held[8]) {
  std::fill_n(held, 8, 0.0);
  double sum[8] = {}, whole[8];
  box_moments(box, whole);
  for (int k = 0; k < kLattice * kLattice * kLattice; ++k) {
    const int at[3] = {k % kLattice, k / kLattice % kLattice, k / kLattice / kLattice};
    Vec3 x;
    for (size_t d = 0; d < 3; ++d)
      x[d] = box.lower[d] + box.extent(int(d)) * (at[d] + 0.5) / kLattice;
    bool inside = false;
    for (const Border& border : borders) inside = inside || distance(border, x) <= 0;
    for (int c = 0; c < 8; ++c) {
      double N = 1;
      for (size_t d = 0; d < 3; ++d) N *= c >> d & 1 ? x[d] : 1 - x[d];
      sum[c] += N;
      if (inside) held[c] += N;
    }
  }
  for (int c = 0; c < 8; ++c) held[c] *= sum[c] > 0 ? whole[c] / sum[c] : 0;
}

/// Cuts the voxels of one body.
class Cutter {
 public:
  Cutter(const CutBody& body, const std::vector<Border>& borders) {
    for (const Border& border : borders)
      borders_.push_back(border_on_lattice(border, body.lattice));
    for (const Vec3& vertex : body.mesh.vertices) box_.add(vertex);
  }

  /// Fills `cut` but for its coordinates from the integrals over what the body fills of a voxel.
  /// @return whether something is held.
  bool cut(const Coord& voxel, const double of_body[8], CutVoxel& result) const {
    // the part of the voxel within the body's box, and the borders that meet it
    Box part;
    for (size_t d = 0; d < 3; ++d) {
      part.lower[d] = std::max(box_.lower[d] - voxel[d], 0.0);
      part.upper[d] = std::min(box_.upper[d] - voxel[d], 1.0);
      if (part.extent(int(d)) < kFlat) part.lower[d] = 0, part.upper[d] = 1;
    }
    const MetBorders met = borders_at(voxel, part);
    if (met.number.empty()) return false;
    // shares that they hold
    double whole[8], held[8], body_share = 0;
    box_moments(part, whole);
    shares(part, met, held);
    result.share = 0;
    for (int c = 0; c < 8; ++c) {
      const double free = whole[c] > 0 ? std::clamp(1 - held[c] / whole[c], 0.0, 1.0) : 0;
      body_share += of_body[c];
      result.share += result.moment[c] = std::max(of_body[c], 0.0) * free;
    }
    result.borders = met.number;
    return met.balls || body_share - result.share > kHeld;
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

  static void shares(const Box& part, const MetBorders& met, double held[8]) {
    if (met.balls || met.border.size() > kMostBoxes)
      union_of_borders(part, met.border, held);
    else
      union_of_boxes(part, met.border, held);
  }

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
  const auto add = [&](const Coord& at, const double moment[8]) {
    CutVoxel cut;
    cut.coord = at;
    const bool is_cut = cutter.cut(at, moment, cut);
    if (is_cut) result.held += sum_of(moment) - cut.share;
    if (is_cut && cut.share <= kNothing) return;
    kept.insert(kept.end(), at.begin(), at.end());
    if (is_cut) result.cut.push_back(std::move(cut));
  };
  // border voxels, then those without surface
  for (int64_t c = 0; c < body.cells.count(); ++c) {
    if (!body.kept[size_t(c)]) continue;
    double moment[8];
    filled_moments(body, c, moment);
    add(body.cells.coord[size_t(c)], moment);
  }
  for (const Run& run : body.fill.full)
    for (int32_t i = 0; i < run.length; ++i)
      add({run.first[0] + i, run.first[1], run.first[2]}, kFullVoxel);
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
        cutter.cut(body.cells.coord[size_t(c)], moment, cut) && cut.share > kNothing;
  }
  return result;
}

}  // namespace elastogen
