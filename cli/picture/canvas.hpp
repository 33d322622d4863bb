// SPDX-License-Identifier: Apache-2.0
// Strips of a picture: samples with depth, filled triangle by triangle.

#pragma once

#include "core/parallel.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace elastogen {

/// Linear red, green and blue light.
using Light = std::array<float, 3>;

inline constexpr int kSamples = 2;         ///< along each edge of a pixel; the pixel is their mean
inline constexpr float kNothing = -1e30f;  ///< depth of a sample that shows nothing

/// Whole rows of samples: the light of each, and the depth of the surface seen there, which grows
/// towards the viewer.
struct Canvas {
  Canvas(int width, int first, int rows)
      : width(width),
        first(first),
        rows(rows),
        light(size_t(width) * size_t(rows)),
        depth(light.size(), kNothing) {}

  size_t sample(int x, int y) const { return size_t(y - first) * size_t(width) + size_t(x); }

  int width, first, rows;  ///< the rows are first ... first + rows - 1 of the picture
  std::vector<Light> light;
  std::vector<float> depth;  ///< [m]
};

/// Indices of the samples whose middles may lie between two places.
struct SampleRange {
  SampleRange(double low, double high, int least, int most)
      : begin(int(std::clamp(std::floor(low), double(least), double(most)))),
        end(int(std::clamp(std::ceil(high), double(least), double(most)))) {}
  int begin, end;
};

/// Calls visit(sample, weights, depth) for the samples of a canvas whose middles lie in a triangle
/// of projected corners; `weights` belong to the corners.
template <class Visit>
void fill_triangle(const Canvas& canvas, const Vec3& p, const Vec3& q, const Vec3& r,
                   const Visit& visit) {
  const double area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
  if (!(std::abs(area) > 0)) return;
  const SampleRange rows(std::min({p[1], q[1], r[1]}), std::max({p[1], q[1], r[1]}), canvas.first,
                         canvas.first + canvas.rows);
  const SampleRange columns(std::min({p[0], q[0], r[0]}), std::max({p[0], q[0], r[0]}), 0,
                            canvas.width);
  for (int y = rows.begin; y < rows.end; ++y)
    for (int x = columns.begin; x < columns.end; ++x) {
      const double sx = x + 0.5, sy = y + 0.5;
      const double u = ((q[0] - sx) * (r[1] - sy) - (q[1] - sy) * (r[0] - sx)) / area;
      const double v = ((r[0] - sx) * (p[1] - sy) - (r[1] - sy) * (p[0] - sx)) / area;
      const double w = 1 - u - v;
      if (u < 0 || v < 0 || w < 0) continue;
      visit(canvas.sample(x, y), Vec3{u, v, w}, u * p[2] + v * q[2] + w * r[2]);
    }
}

/// A picture of 8-bit sRGB, row by row from the top.
struct Pixels {
  Pixels(int width, int height, uint8_t value = 255)
      : width(width), height(height), rgb(3 * size_t(width) * size_t(height), value) {}
  uint8_t* row(int x, int y) { return rgb.data() + 3 * (size_t(y) * size_t(width) + size_t(x)); }

  int width, height;
  std::vector<uint8_t> rgb;
};

/// Rows of samples in a strip, a whole number of pixels.
inline constexpr int kStripRows = 32 * kSamples;

/// Calls draw(canvas) for all strips of a picture with this many samples, in any order.
template <class Draw>
void for_strips(int width, int height, const Draw& draw) {
  run_tasks((height + kStripRows - 1) / kStripRows, [&](int64_t strip) {
    const int first = int(strip) * kStripRows;
    Canvas canvas(width, first, std::min(kStripRows, height - first));
    draw(canvas);
  });
}

/// Averages the samples of a canvas into its rows of a picture.
void develop(const Canvas& canvas, Pixels& pixels);

/// The linear light of an sRGB colour.
Light light_of_srgb(const Vec3& colour);

}  // namespace elastogen
