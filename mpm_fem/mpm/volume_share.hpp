// SPDX-License-Identifier: Apache-2.0
// How far a deformation may go before a point has lost most of its volume.

#pragma once

#include "core/mat3.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

/// Smallest t in (0, 1] at which det(I + t A) falls to `left` < 1, or 1 where it does not before.
///
///     det(I + t A) = 1 + t tr A + t^2 tr cof A + t^3 det A:
///
/// its extremes part [0, 1] into stretches where it rises or falls throughout.
inline double share_to_volume(const Mat3<double>& A, double left) {
  const Mat3<double> C = cofactor(A);
  const double c[4] = {1 - left, A(0, 0) + A(1, 1) + A(2, 2), C(0, 0) + C(1, 1) + C(2, 2),
                       determinant(A)};
  const auto value = [&](double t) { return c[0] + t * (c[1] + t * (c[2] + t * c[3])); };
  double ends[3] = {1, 1, 1};
  const double square = c[2] * c[2] - 3 * c[3] * c[1];
  if (square > 0) {
    // the two roots of c1 + 2 c2 t + 3 c3 t^2 without cancellation
    const double q = -(c[2] + std::copysign(std::sqrt(square), c[2]));
    if (q != 0) ends[0] = c[1] / q;
    if (c[3] != 0) ends[1] = q / (3 * c[3]);
    std::sort(ends, ends + 2);
  }
  double from = 0;
  for (double to : ends) {
    if (!(to > from)) continue;
    to = std::min(to, 1.0);
    if (value(to) < 0) {
      for (int k = 0; k < 60; ++k) {
        const double middle = (from + to) / 2;
        (value(middle) < 0 ? to : from) = middle;
      }
      return from;
    }
    from = to;
  }
  return 1;
}

}  // namespace elastogen
