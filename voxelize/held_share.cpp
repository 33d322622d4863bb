// SPDX-License-Identifier: Apache-2.0
#include "voxelize/held_share.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

constexpr int kLattice = 8;       // points along an edge
constexpr size_t kMostBoxes = 6;  // boxes whose union is found exactly

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

/// The axis along which a border's faces cut a box, or a ball lies.
int axis_of(const Border& border, const Box& box) {
  int best = 0;
  double most = -1;
  for (size_t d = 0; d < 3; ++d) {
    const bool cuts = (border.lower[d] > box.lower[d] && border.lower[d] < box.upper[d]) ||
                      (border.upper[d] > box.lower[d] && border.upper[d] < box.upper[d]);
    const double middle = (box.lower[d] + box.upper[d]) / 2;
    const double fits = border.radius > 0 ? std::abs(border.lower[d] - middle) : double(cuts);
    if (fits > most) most = fits, best = int(d);
  }
  return best;
}

using Interval = std::array<double, 2>;

/// The part of a line through p along an axis that lies behind a border; empty if it ends before it
/// begins.
Interval held_interval(const Border& border, const Vec3& p, int axis) {
  const auto a = size_t(axis);
  if (border.radius > 0) {
    double away = 0;
    for (size_t d = 0; d < 3; ++d) away += d == a ? 0 : std::pow(p[d] - border.lower[d], 2);
    const double square = border.radius * border.radius - away;
    if (!(square > 0)) return {1, 0};
    return {border.lower[a] - std::sqrt(square), border.lower[a] + std::sqrt(square)};
  }
  for (size_t d = 0; d < 3; ++d)
    if (d != a && (p[d] < border.lower[d] || p[d] > border.upper[d])) return {1, 0};
  return {border.lower[a], border.upper[a]};
}

/// Adds what ascending intervals leave of a part of a line.
void add_free(double from, double to, const std::vector<Interval>& held, LineSums& sums) {
  for (const auto& [lower, upper] : held) {
    if (upper <= from || lower >= to) continue;
    if (lower > from) sums.add(from, lower);
    from = upper;
    if (from >= to) return;
  }
  sums.add(from, to);
}

/// Integrals over the inside along lines, and over what borders leave of it.
struct LineMoments {
  double inside[8] = {}, free[8] = {};
  double length = 0;            ///< of what is left, the mean over lines that have some
  double lower = 1, upper = 0;  ///< ends of the inside
};

LineMoments along_lines(const LocalTriangles& surface, const Box& box, int axis, double w,
                        const std::vector<Border>& borders) {
  LineMoments result;
  int met = 0;
  // what lies behind a border of each line, then what is inside, and what is left of it
  std::vector<Interval> held;
  for_each_line(surface, box, axis, w, [&](const Crossings& crossings, double at, const Vec3& p) {
    held.clear();
    for (const Border& border : borders)
      if (const Interval part = held_interval(border, p, axis); part[0] < part[1])
        held.push_back(part);
    std::ranges::sort(held);
    LineSums inside, free;
    for_each_inside(crossings, at, p, axis, [&](double from, double to) {
      inside.add(from, to);
      result.lower = std::min(result.lower, from);
      result.upper = std::max(result.upper, to);
      add_free(from, to, held, free);
    });
    inside.add_to(result.inside, p, axis, 1);
    free.add_to(result.free, p, axis, 1);
    result.length += free.length;
    met += free.length > 0;
  });
  if (met > 0) result.length /= met;
  return result;
}

/// How far integrals are from being in proportion to those of the body, squared; both (8).
double mismatch(const double a[8], const double b[8]) {
  double scale_a = 0, scale_b = 0, sum = 0;
  for (int c = 0; c < 8; ++c) scale_a += a[c], scale_b += b[c];
  if (!(scale_a > 0 && scale_b > 0)) return 1e300;
  for (int c = 0; c < 8; ++c) sum += std::pow(a[c] / scale_a - b[c] / scale_b, 2);
  return sum;
}

/// Whether a body fills just a box.
bool fills(const Box& box, const double of_body[8]) {
  constexpr double kSame = 1e-9;
  double moment[8];
  box_moments(box, moment);
  for (int c = 0; c < 8; ++c)
    if (std::abs(moment[c] - of_body[c]) > kSame) return false;
  return true;
}

}  // namespace

void free_shares(const Box& box, const std::vector<Border>& borders, double free[8]) {
  const bool balls =
      std::ranges::any_of(borders, [](const Border& border) { return border.radius > 0; });
  double whole[8], held[8];
  box_moments(box, whole);
  balls || borders.size() > kMostBoxes ? union_of_borders(box, borders, held)
                                       : union_of_boxes(box, borders, held);
  for (int c = 0; c < 8; ++c)
    free[c] = whole[c] > 0 ? std::clamp(1 - held[c] / whole[c], 0.0, 1.0) : 0;
}

Vec3 free_shares_inside(const LocalTriangles& surface, const double of_body[8], const Box& box,
                        const std::vector<Border>& borders, double free[8]) {
  const double body = std::accumulate(of_body, of_body + 8, 0.0);
  Vec3 thickness = {body, body, body};
  if (surface.empty() || borders.empty()) return thickness;
  const int axis = axis_of(borders.front(), box);
  // the winding number at the first line is the one whose inside is most like the body
  double best = 1e300, first = 0;
  LineMoments found;
  for (const double w : {0.0, 1.0, -1.0, 2.0}) {
    const LineMoments moments = along_lines(surface, box, axis, w, borders);
    const double off = mismatch(moments.inside, of_body);
    if (off < best) best = off, found = moments, first = w;
  }
  for (int c = 0; c < 8; ++c)
    if (found.inside[c] > 0) free[c] = std::clamp(found.free[c] / found.inside[c], 0.0, 1.0);
  Box inside;
  for (size_t d = 0; d < 3; ++d) {
    const LineMoments along = along_lines(surface, box, int(d), first, borders);
    if (along.length > 0) thickness[d] = std::min(along.length, 1.0);
    inside.lower[d] = along.lower, inside.upper[d] = along.upper;
  }
  if (fills(inside, of_body)) free_shares(inside, borders, free);
  return thickness;
}

}  // namespace elastogen
