// SPDX-License-Identifier: Apache-2.0
#include "voxelize/fill_fraction.hpp"

#include <cmath>

namespace elastogen {
namespace {

constexpr double kClosed = 1e-3;  // largest error of a winding number and of the sum of moments

/// Sums of the fluxes of the cells before a place in a row.
struct Carry {
  double flux[4] = {};

  /// Adds the flux of a voxel.
  void add(const double* more) {
    for (int k = 0; k < 4; ++k) flux[k] += more[k];
  }
  /// Winding number of the voxels that follow, rounded to empty or full; no value if it is neither.
  std::optional<int> settle(int sign) {
    const double w = std::round(flux[0] + flux[1] + flux[2] + flux[3]);
    if (w != 0 && w != sign) return std::nullopt;
    for (double& f : flux) {
      if (!(std::abs(f - w / 4) < kClosed)) return std::nullopt;
      f = w / 4;
    }
    return static_cast<int>(w) * sign;
  }
};

}  // namespace

int64_t Fill::full_voxels() const {
  int64_t sum = 0;
  for (const Run& run : full) sum += run.length;
  return sum;
}

std::optional<Fill> exact_fill(const SurfaceCells& cells, int sign) {
  Fill fill;
  fill.moment = Array<double>(cells.count(), 8);
  Carry carry;
  for (int64_t c = 0; c < cells.count(); ++c) {
    const Coord& cell = cells.coord[c];

    // the voxel of the cell
    double sum = 0;
    for (int k = 0; k < 8; ++k)
      sum += fill.moment(c, k) = sign * (cells.ahead(c, k) + carry.flux[k >> 1] / 2);
    if (!(sum > -kClosed && sum < 1 + kClosed)) return std::nullopt;
    fill.volume += sum;
    carry.add(cells.flux.row(c));

    // the voxels up to the next one of its row
    const bool last = c + 1 == cells.count() || cells.coord[c + 1][1] != cell[1] ||
                      cells.coord[c + 1][2] != cell[2];
    const int32_t gap = last ? 0 : cells.coord[c + 1][0] - cell[0] - 1;
    if (!last && gap == 0) continue;
    const std::optional<int> inside = carry.settle(sign);
    if (!inside || (last && *inside)) return std::nullopt;
    if (*inside) {
      fill.full.push_back({{cell[0] + 1, cell[1], cell[2]}, gap});
      fill.volume += gap;
    }
  }
  return fill;
}

}  // namespace elastogen
