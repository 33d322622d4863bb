// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/sun.hpp"

namespace elastogen {
namespace {

constexpr int kTaps = 5;          // samples of the map for one shadow, along each axis
constexpr double kSoft = 1.6;     // distance between these [samples of the map]
constexpr double kClear = 0.004;  // least height that shades, as a share of the map

}  // namespace

Sun::Sun(const Camera& above) : above_(above), height_(size_t(kEdge * kEdge), kNothing) {}

void Sun::take(const Canvas& canvas) {
  std::copy(canvas.depth.begin(), canvas.depth.end(),
            height_.begin() + int64_t(canvas.first) * kEdge);
}

float Sun::shadow(const Vec3& place) const {
  const Vec3 p = above_.project(place);
  const double reach = kSoft * (kTaps / 2), edge = kEdge;
  if (p[0] < -reach || p[1] < -reach || p[0] > edge + reach || p[1] > edge + reach) return 0;
  const auto least = float(p[2] + kClear * edge / above_.scale);
  int covered = 0;
  for (int k = 0; k < kTaps * kTaps; ++k) {
    const double x = std::floor(p[0] + kSoft * (k % kTaps - kTaps / 2));
    const double y = std::floor(p[1] + kSoft * (k / kTaps - kTaps / 2));
    if (x < 0 || y < 0 || x >= edge || y >= edge) continue;
    covered += height_[size_t(y) * kEdge + size_t(x)] > least;
  }
  return float(covered) / (kTaps * kTaps);
}

}  // namespace elastogen
