// SPDX-License-Identifier: Apache-2.0
#include "voxelize/from_splats.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"
#include "io/splat_motion.hpp"
#include "voxelize/point_spacing.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr float kLeastOpacity = 0.1f, kLargest = 10;
constexpr int kMostSteps = 8;  // points from the centre along an axis

bool is_finite(const SplatCloud& splats, size_t i) {
  bool finite = std::isfinite(splats.opacity[i]);
  for (const double x : splats.position[i]) finite = finite && std::isfinite(x);
  for (const float s : splats.scale[i]) finite = finite && std::isfinite(s);
  for (const float q : splats.rotation[i]) finite = finite && std::isfinite(q);
  return finite;
}

float longest_axis(const SplatCloud& splats, size_t i) {
  return *std::max_element(splats.scale[i].begin(), splats.scale[i].end());
}

/// The splats that show a surface.
std::vector<size_t> chosen(const SplatCloud& splats) {
  std::vector<size_t> shown;
  std::vector<float> size;
  for (size_t i = 0; i < splats.position.size(); ++i)
    if (is_finite(splats, i) && splats.opacity[i] > kLeastOpacity) {
      shown.push_back(i);
      size.push_back(longest_axis(splats, i));
    }
  if (shown.empty()) return shown;
  const auto middle = size.begin() + int64_t(size.size() / 2);
  std::nth_element(size.begin(), middle, size.end());
  const float limit = kLargest * *middle;
  std::erase_if(shown, [&](size_t i) { return longest_axis(splats, i) > limit; });
  return shown;
}

/// Adds the points of one splat: an elliptic patch of a lattice on its two longest axes.
void sample(const SplatCloud& splats, size_t i, double spacing, std::vector<Vec3>& points) {
  const auto& scale = splats.scale[i];
  const int thin = int(std::min_element(scale.begin(), scale.end()) - scale.begin());
  const int axes[2] = {(thin + 1) % 3, (thin + 2) % 3};
  const Mat3<double> R = rotation_matrix(splats.rotation[i]);
  Vec3 step[2];
  int steps[2];
  for (int k = 0; k < 2; ++k) {
    const double sigma = scale[size_t(axes[k])];
    steps[k] = int(std::clamp(std::floor(sigma / spacing), 0.0, double(kMostSteps)));
    const int a = axes[k];
    step[k] = scaled({R(0, a), R(1, a), R(2, a)}, sigma / std::max(steps[k], 1));
  }
  for (int a = -steps[0]; a <= steps[0]; ++a)
    for (int b = -steps[1]; b <= steps[1]; ++b) {
      const double u = double(a) / std::max(steps[0], 1), v = double(b) / std::max(steps[1], 1);
      if (u * u + v * v > 1) continue;
      const Vec3 offset = plus(scaled(step[0], a), scaled(step[1], b));
      points.push_back(plus(splats.position[i], offset));
    }
}

/// Standard deviations of a splat along the axes of space, sqrt(S_dd) of S = R diag(scale^2) R^T.
Vec3 spread(const SplatCloud& splats, size_t i) {
  const Mat3<double> R = rotation_matrix(splats.rotation[i]);
  Vec3 result;
  for (int d = 0; d < 3; ++d) {
    double square = 0;
    for (int k = 0; k < 3; ++k) square += std::pow(R(d, k) * splats.scale[i][size_t(k)], 2);
    result[size_t(d)] = std::sqrt(square);
  }
  return result;
}

}  // namespace

Box shown_box(const SplatCloud& splats, const Box& bulk, double margin) {
  Box box;
  for (const size_t i : chosen(splats)) {
    const Vec3& p = splats.position[i];
    bool inside = true;
    for (size_t d = 0; d < 3; ++d)
      inside = inside && p[d] >= bulk.lower[d] - margin && p[d] <= bulk.upper[d] + margin;
    if (!inside) continue;
    box.add(minus(p, spread(splats, i)));
    box.add(plus(p, spread(splats, i)));
  }
  return box.lower[0] <= box.upper[0] ? box : bulk;
}

SplatSamples sample_splats(const SplatCloud& splats, const std::string& place, double grain) {
  const std::vector<size_t> shown = chosen(splats);
  ELASTOGEN_CHECK_ASSET(!shown.empty(), place, ": none of its ", splats.position.size(),
                        " splats shows a surface (opacity above ", kLeastOpacity, ')');
  SplatSamples result;
  std::vector<Vec3> centres;
  for (const size_t i : shown) centres.push_back(splats.position[i]);
  const double spacing = std::max(point_spacing(centres), grain);
  if (spacing == 0) {
    result.points = std::move(centres);
  } else {
    for (const size_t i : shown) sample(splats, i, spacing, result.points);
  }
  const int64_t left_out = int64_t(splats.position.size() - shown.size());
  if (left_out > 0)
    result.findings.push_back(
        {"splats", left_out, "splats are too faint or too large to show a surface"});
  return result;
}

}  // namespace elastogen
