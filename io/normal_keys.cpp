// SPDX-License-Identifier: Apache-2.0
#include "io/normal_keys.hpp"

#include "core/error.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace elastogen {

namespace {

/// Root mean square over vertices of the distance between the normals of frame t and those that are
/// interpolated between the frames a < t < b and scaled to length one.
double interpolation_error(const Array<float>& normals, int64_t a, int64_t t, int64_t b) {
  const double s = double(t - a) / double(b - a);
  const float *from = normals.row(a), *to = normals.row(b), *exact = normals.row(t);
  double sum = 0;
  for (int i = 0; i < normals.cols(); i += 3) {
    double n[3], square = 0;
    for (int d = 0; d < 3; ++d) {
      n[d] = (1 - s) * double(from[i + d]) + s * double(to[i + d]);
      square += n[d] * n[d];
    }
    const double length = std::sqrt(std::max(square, 1e-30));
    for (int d = 0; d < 3; ++d) {
      const double e = n[d] / length - double(exact[i + d]);
      sum += e * e;
    }
  }
  return std::sqrt(3 * sum / double(std::max(normals.cols(), 1)));
}

/// The frame between two keys whose normals the interpolation gives worst.
struct Worst {
  int64_t frame = -1;
  double error = 0;
};

Worst worst_between(const Array<float>& normals, int64_t a, int64_t b) {
  Worst worst;
  for (int64_t t = a + 1; t < b; ++t) {
    const double error = interpolation_error(normals, a, t, b);
    if (error > worst.error) worst = {t, error};
  }
  return worst;
}

/// Weights of the keys: hat functions between neighbours in `knots`, which include still frames.
Array<float> hats(const std::vector<int64_t>& knots, const std::vector<int64_t>& keys,
                  const FrameRange& range) {
  Array<float> weights(range.count(), int(keys.size()));
  const auto set = [&](int64_t frame, int64_t knot, double weight) {
    const auto key = std::lower_bound(keys.begin(), keys.end(), knot);
    if (key != keys.end() && *key == knot)
      weights(frame - range.first, int(key - keys.begin())) = float(weight);
  };
  for (size_t k = 0; k < knots.size(); ++k) {
    set(knots[k], knots[k], 1);
    for (int64_t t = knots[k] + 1; k + 1 < knots.size() && t < knots[k + 1]; ++t) {
      const double s = double(t - knots[k]) / double(knots[k + 1] - knots[k]);
      set(t, knots[k], 1 - s);
      set(t, knots[k + 1], s);
    }
  }
  return weights;
}

}  // namespace

NormalKeys normal_keys(const Array<float>& normals, const FrameRange& range,
                       const std::vector<int64_t>& moving, int most, double tolerance) {
  ELASTOGEN_CHECK(most >= 2 && range.first >= 0 && range.last < normals.rows(),
                  "normals need two keys and every frame of the range, got ", most, " and ",
                  normals.rows(), " frames");
  const auto is_moving = [&](int64_t t) {
    return std::binary_search(moving.begin(), moving.end(), t);
  };
  // knots are the ends and every still frame; keys are the knots that move
  std::vector<int64_t> knots, keys;
  for (int64_t t = range.first; t <= range.last; ++t) {
    const bool key = is_moving(t);
    if (key && t != range.first && t != range.last) continue;
    knots.push_back(t);
    if (key) keys.push_back(t);
  }
  std::map<int64_t, Worst> gaps;  // worst frame of each gap, by the knot before it
  for (size_t k = 0; k + 1 < knots.size(); ++k)
    gaps[knots[k]] = worst_between(normals, knots[k], knots[k + 1]);

  NormalKeys result;
  while (!gaps.empty()) {
    const auto by_error = [](const auto& a, const auto& b) {
      return a.second.error < b.second.error;
    };
    const auto gap = std::max_element(gaps.begin(), gaps.end(), by_error);
    result.error = gap->second.error;
    if (result.error <= tolerance || int(keys.size()) >= most) break;
    const int64_t frame = gap->second.frame;
    knots.insert(std::upper_bound(knots.begin(), knots.end(), frame), frame);
    keys.insert(std::upper_bound(keys.begin(), keys.end(), frame), frame);
    const auto next = std::upper_bound(knots.begin(), knots.end(), frame);
    gap->second = worst_between(normals, gap->first, frame);
    gaps[frame] = worst_between(normals, frame, *next);
  }
  result.weights = hats(knots, keys, range);
  result.frames = std::move(keys);
  return result;
}

}  // namespace elastogen
