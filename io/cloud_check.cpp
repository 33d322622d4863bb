// SPDX-License-Identifier: Apache-2.0
#include "io/cloud_check.hpp"

#include "core/error.hpp"
#include "io/asset_check.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen {
namespace {

/// Keeps the given rows of a (rows, n) array in their order.
template <class Values>
void keep(Values& values, const std::vector<size_t>& rows, size_t n = 1) {
  if (values.empty()) return;
  size_t end = 0;
  for (const size_t row : rows)
    for (size_t k = 0; k < n; ++k) values[end++] = values[row * n + k];
  values.resize(end);
}

/// Rows that are good, with a finding if any is not. @throws Error (asset) if none is good.
template <class IsGood>
std::vector<size_t> good_rows(Asset& asset, size_t count, const char* name, const IsGood& is_good) {
  ELASTOGEN_CHECK_ASSET(count > 0, asset.path, ": has no ", name, ": nothing to simulate");
  std::vector<size_t> rows;
  size_t first_bad = count;
  for (size_t i = 0; i < count; ++i) {
    if (is_good(i)) {
      rows.push_back(i);
    } else {
      first_bad = std::min(first_bad, i);
    }
  }
  ELASTOGEN_CHECK_ASSET(!rows.empty(), asset.path, ": none of its ", count, ' ', name,
                        " is finite: nothing to simulate");
  add_finding(asset, concat("bad-", name), int64_t(count - rows.size()),
              concat(name, " are not finite, the first is number ", first_bad,
                     " (counted from 0); outputs hold the others in the file's order"));
  return rows;
}

/// @throws Error (asset) unless the positions span a length that can be computed with.
void check_extent(const Asset& asset, const std::vector<Vec3>& position, bool may_be_one) {
  Box box;
  for (const Vec3& x : position) box.add(x);
  const double longest = std::max({box.extent(0), box.extent(1), box.extent(2)});
  ELASTOGEN_CHECK_ASSET(longest > 0 || may_be_one, asset.path, ": all its points lie in one place");
  ELASTOGEN_CHECK_ASSET(longest < kMaxLength && (longest > 1 / kMaxLength || longest == 0),
                        asset.path, ": its longest edge of ", longest, " is out of range");
}

void check_points(Asset& asset) {
  PointCloud& points = *asset.points;
  const auto rows = good_rows(asset, points.position.size(), "points",
                              [&](size_t i) { return are_finite(points.position[i]); });
  keep(points.position, rows);
  keep(points.normal, rows);
  keep(points.colour, rows);
  keep(points.own.rows, rows, points.own.row_bytes());
  check_extent(asset, points.position, false);
  reset_bad_rows(asset, points.normal, {0, 0, 1}, "normals");
  reset_bad_rows(asset, points.colour, {1, 1, 1, 1}, "colours");
}

/// Gives quaternions the length one; those of length zero become the identity.
void normalise(Asset& asset, std::vector<std::array<float, 4>>& rotation) {
  int64_t bad = 0;
  for (std::array<float, 4>& q : rotation) {
    double square = 0;
    for (const float x : q) square += double(x) * x;
    const double norm = std::sqrt(square);
    if (!(norm > 0) || !std::isfinite(norm)) {
      q = {1, 0, 0, 0};
      ++bad;
      continue;
    }
    for (float& x : q) x = float(x / norm);
  }
  add_finding(asset, "bad-rotations", bad, "splats have a quaternion of no length or not finite");
}

void check_splats(Asset& asset) {
  // drop splats without a finite place, size or opacity, and their rows in every array
  SplatCloud& splats = *asset.splats;
  const auto is_good = [&](size_t i) {
    return are_finite(splats.position[i]) && are_finite(splats.scale[i]) &&
           *std::ranges::min_element(splats.scale[i]) >= 0 && std::isfinite(splats.opacity[i]);
  };
  const size_t harmonics = 3 * size_t(splats.degree + 1) * size_t(splats.degree + 1);
  const auto rows = good_rows(asset, splats.position.size(), "splats", is_good);
  keep(splats.position, rows);
  keep(splats.scale, rows);
  keep(splats.rotation, rows);
  keep(splats.opacity, rows);
  keep(splats.harmonics, rows, harmonics);
  keep(splats.own.rows, rows, splats.own.row_bytes());
  check_extent(asset, splats.position, true);

  // attributes of the others are repaired: scales need a logarithm, rotations a length
  for (auto& scale : splats.scale)
    for (float& s : scale) s = std::max(s, std::numeric_limits<float>::min());
  normalise(asset, splats.rotation);
  // harmonics that are not finite only lose colour
  int64_t bad = 0;
  for (float& x : splats.harmonics) {
    if (std::isfinite(x)) continue;
    x = 0;
    ++bad;
  }
  add_finding(asset, "bad-harmonics", bad, "coefficients are not finite");
}

}  // namespace

void check_cloud(Asset& asset) {
  asset.points ? check_points(asset) : check_splats(asset);
}

}  // namespace elastogen
