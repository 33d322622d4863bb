// SPDX-License-Identifier: Apache-2.0
#include "core/path.hpp"

#include "core/error.hpp"
#include "core/vec3.hpp"

#include <cmath>
#include <limits>

namespace elastogen {
namespace {

double duration(const Path& path) {
  return path.keys.back().time - path.keys.front().time;
}

/// Rounds of a loop that are complete just before a time.
double rounds_before(const Path& path, double time) {
  const double start = path.keys.front().time;
  if (!path.loops || time <= start) return 0;
  return std::max(0.0, std::ceil((time - start) / duration(path)) - 1);
}

/// The key before a time and the share of the way to the next one, in (0, 1]; -1: at rest.
struct Segment {
  int64_t first = -1;
  double share = 0;
};

Segment segment_at(const Path& path, double time) {
  if (!path.moves() || time <= path.keys.front().time) return {};
  time -= rounds_before(path, time) * duration(path);
  for (size_t k = 1; k < path.keys.size(); ++k) {
    const double from = path.keys[k - 1].time, to = path.keys[k].time;
    if (time <= to) return {int64_t(k - 1), (time - from) / (to - from)};
  }
  return {};
}

}  // namespace

Vec3 offset_at(const Path& path, double time) {
  if (path.keys.empty()) return {};
  if (time <= path.keys.front().time) return path.keys.front().offset;
  const auto [first, share] = segment_at(path, time);
  if (first < 0) return path.keys.back().offset;
  const Vec3 &a = path.keys[size_t(first)].offset, &b = path.keys[size_t(first + 1)].offset;
  const double s = path.eases ? share * share * (3 - 2 * share) : share;
  Vec3 offset;
  for (size_t d = 0; d < 3; ++d) offset[d] = a[d] + s * (b[d] - a[d]);
  return offset;
}

Vec3 rate_at(const Path& path, double time) {
  const auto [first, share] = segment_at(path, time);
  if (first < 0) return {};
  const PathKey &a = path.keys[size_t(first)], &b = path.keys[size_t(first + 1)];
  const double slope = path.eases ? 6 * share * (1 - share) : 1;
  return scaled(minus(b.offset, a.offset), slope / (b.time - a.time));
}

Vec3 acceleration_at(const Path& path, double time) {
  const auto [first, share] = segment_at(path, time);
  if (first < 0 || !path.eases) return {};
  const PathKey &a = path.keys[size_t(first)], &b = path.keys[size_t(first + 1)];
  const double duration = b.time - a.time;
  return scaled(minus(b.offset, a.offset), (6 - 12 * share) / (duration * duration));
}

double next_key(const Path& path, double time) {
  double shift = 0;
  if (path.loops && path.moves() && time > path.keys.front().time)
    shift = std::floor((time - path.keys.front().time) / duration(path)) * duration(path);
  for (const double more : {shift, shift + (path.loops ? duration(path) : 0)})
    for (const PathKey& key : path.keys)
      if (key.time + more > time) return key.time + more;
  return std::numeric_limits<double>::infinity();
}

void check_path(const Path& path) {
  for (size_t k = 0; k < path.keys.size(); ++k) {
    ELASTOGEN_CHECK(std::isfinite(path.keys[k].time) && finite(path.keys[k].offset), "key ", k,
                    " of its path is not finite");
    ELASTOGEN_CHECK(k == 0 || path.keys[k].time > path.keys[k - 1].time,
                    "the times of its path must ascend, key ", k, " does not");
  }
  ELASTOGEN_CHECK(!path.loops || path.moves(), "a path that loops needs two keys");
}

}  // namespace elastogen
