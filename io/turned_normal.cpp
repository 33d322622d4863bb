// SPDX-License-Identifier: Apache-2.0
#include "io/turned_normal.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

std::array<float, 3> turned_normal(const double* F, const std::array<float, 3>& n) {
  const double identity[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  if (std::equal(F, F + 9, identity)) return n;
  double m[3] = {}, square = 0;
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      m[i] += (F[3 * j + e] * F[3 * k + f] - F[3 * j + f] * F[3 * k + e]) * double(n[size_t(d)]);
    }
    square += m[i] * m[i];
  }
  if (square == 0) return n;
  const double norm = 1 / std::sqrt(square);
  return {float(m[0] * norm), float(m[1] * norm), float(m[2] * norm)};
}

}  // namespace elastogen
