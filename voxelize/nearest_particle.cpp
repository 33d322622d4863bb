// SPDX-License-Identifier: Apache-2.0
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/vec3.hpp"
#include "voxelize/particle_surface.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

constexpr double kListCell = 1.7;  // [spacings]: surfaces are nearer than this to their particles

using CellCoord = std::array<int32_t, 3>;

/// Particles, sorted by their cells.
class CellLists {
 public:
  CellLists(In<double> x, double spacing)
      : x_(x), cell_(kListCell * spacing), order_(size_t(x.rows)) {
    std::vector<CellCoord> of(order_.size());
    for (size_t k = 0; k < of.size(); ++k) of[k] = coord(x.row(int64_t(k)));
    std::iota(order_.begin(), order_.end(), 0);
    std::sort(order_.begin(), order_.end(), [&](int32_t a, int32_t b) {
      return of[size_t(a)] != of[size_t(b)] ? of[size_t(a)] < of[size_t(b)] : a < b;
    });
    for (const int32_t k : order_) coord_.push_back(of[size_t(k)]);
  }

  /// Searches the cells around a point, ring by ring.
  int32_t nearest(const Vec3& point) const {
    const CellCoord centre = coord(point.data());
    for (int ring = 1;; ring *= 2) {
      Best best;
      for (int32_t i = centre[0] - ring; i <= centre[0] + ring; ++i)
        for (int32_t j = centre[1] - ring; j <= centre[1] + ring; ++j)
          look({i, j, centre[2] - ring}, {i, j, centre[2] + ring}, point, best);
      if (best.distance2 <= std::pow(ring * cell_, 2)) return best.particle;
    }
  }

 private:
  struct Best {
    double distance2 = 1e300;
    int32_t particle = 0;
  };

  CellCoord coord(const double* x) const {
    CellCoord c;
    for (size_t d = 0; d < 3; ++d) c[d] = int32_t(std::floor(x[d] / cell_));
    return c;
  }

  /// Searches a row of cells.
  void look(const CellCoord& first, const CellCoord& last, const Vec3& point, Best& best) const {
    auto at = std::lower_bound(coord_.begin(), coord_.end(), first);
    for (; at != coord_.end() && *at <= last; ++at) {
      const int32_t k = order_[size_t(at - coord_.begin())];
      const double* x = x_.row(k);
      const Vec3 gap = minus({x[0], x[1], x[2]}, point);
      const double d = dot(gap, gap);
      if (d < best.distance2 || (d == best.distance2 && k < best.particle)) best = {d, k};
    }
  }

  In<double> x_;
  double cell_;
  std::vector<int32_t> order_;    ///< particles, by cell, then number
  std::vector<CellCoord> coord_;  ///< of each of them
};

}  // namespace

std::vector<int32_t> nearest_particles(In<double> x, double spacing,
                                       const std::vector<Vec3>& points) {
  ELASTOGEN_CHECK(x.cols == 3 && (x.rows > 0 || points.empty()),
                  "x must be (particles, 3) with one particle at least, got ", x);
  ELASTOGEN_CHECK(spacing > 0, "the spacing must be positive, got ", spacing);
  const CellLists lists(x, spacing);
  std::vector<int32_t> nearest(points.size());
  for_each(
      int64_t(points.size()),
      [&](int64_t k) { nearest[size_t(k)] = lists.nearest(points[size_t(k)]); }, 64);
  return nearest;
}

}  // namespace elastogen
