// SPDX-License-Identifier: Apache-2.0
// Shared by all files: the host-device marker, small vectors, the version.

#pragma once

#include <array>
#include <cstdint>

#ifdef __CUDACC__
#define ELASTOGEN_HD __host__ __device__
#else
#define ELASTOGEN_HD
#endif

namespace elastogen {

using Vec3 = std::array<double, 3>;

/// Axis-aligned box [m]; empty while lower > upper.
struct Box {
  Vec3 lower = {1e300, 1e300, 1e300};
  Vec3 upper = {-1e300, -1e300, -1e300};

  void add(const Vec3& p) {
    for (int d = 0; d < 3; ++d) {
      lower[d] = p[d] < lower[d] ? p[d] : lower[d];
      upper[d] = p[d] > upper[d] ? p[d] : upper[d];
    }
  }
  double extent(int d) const { return upper[d] - lower[d]; }
};

}  // namespace elastogen
