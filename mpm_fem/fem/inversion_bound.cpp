// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/fem/inversion_bound.hpp"

#include "mpm_fem/fem/element_state.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::fem {
namespace {

constexpr double kLeastJ = 0.1;  // share of det F that a step leaves
constexpr double kBefore = 0.9;  // of the share at which it gets there

/// The first a in (0, 1] where c0 + c1 a + c2 a^2 + c3 a^3 <= 0, 1 where there is none; c0 > 0.
double first_zero(const double c[4]) {
  const auto value = [&](double a) { return c[0] + a * (c[1] + a * (c[2] + a * c[3])); };
  // between the extrema the cubic is monotone
  double ends[4] = {0, 1, 1, 1};
  const double half = c[2] * c[2] - 3 * c[1] * c[3];
  if (half >= 0) {
    const double q = -(c[2] + std::copysign(std::sqrt(half), c[2]));
    ends[1] = c[3] != 0 ? std::clamp(q / (3 * c[3]), 0.0, 1.0) : 1;
    ends[2] = q != 0 ? std::clamp(c[1] / q, 0.0, 1.0) : 1;
    if (ends[2] < ends[1]) std::swap(ends[1], ends[2]);
  }
  for (int k = 0; k < 3; ++k) {
    double lower = ends[k], upper = ends[k + 1];
    if (value(upper) > 0) continue;
    for (int half_steps = 0; half_steps < 30; ++half_steps) {
      const double middle = (lower + upper) / 2;
      (value(middle) > 0 ? lower : upper) = middle;
    }
    return lower;
  }
  return 1;
}

}  // namespace

double share_before_inversion(const Mat3<double>& F, const Mat3<double>& end) {
  Mat3<double> dF;
  for (int k = 0; k < 9; ++k) dF.m[k] = end.m[k] - F.m[k];
  const double J = determinant(F);
  if (!(J > 0)) return 1;
  const double c[4] = {(1 - kLeastJ) * J, inner(cofactor(F), dF), inner(cofactor(dF), F),
                       determinant(dF)};
  const double share = first_zero(c);
  return share < 1 ? kBefore * share : 1;
}

}  // namespace elastogen::fem
