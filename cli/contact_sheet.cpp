// SPDX-License-Identifier: Apache-2.0
#include "cli/contact_sheet.hpp"

#include "cli/png.hpp"
#include "core/error.hpp"
#include "core/vec3.hpp"
#include "io/safe_file.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace elastogen {

namespace {

constexpr int kSamples = 2;  // a pixel is the mean of 2 x 2
constexpr Vec3 kGround = {0.86, 0.87, 0.89}, kShadow = {0.62, 0.63, 0.66},
               kSky = {0.96, 0.97, 0.98};

Vec3 unit(const Vec3& a) {
  return scaled(a, 1 / std::max(norm(a), 1e-300));
}
Vec3 at(In<double> x, int64_t row) {
  return {x(row, 0), x(row, 1), x(row, 2)};
}

/// Orthographic view: right, up and back (towards the viewer) in the axes of the asset.
struct Camera {
  explicit Camera(int up_axis) {
    Vec3 vertical = {}, towards = {};
    vertical[up_axis] = 1;
    towards[up_axis] = 0.45;
    towards[(up_axis + 1) % 3] = 1;  // z, the front of a y-up asset
    towards[(up_axis + 2) % 3] = 0.6;
    back = unit(towards);
    right = unit(cross(vertical, back));
    up = cross(back, right);
  }
  Vec3 turn(const Vec3& p) const { return {dot(right, p), dot(up, p), dot(back, p)}; }
  /// Place on the grid of samples (y down) and depth.
  Vec3 project(const Vec3& p) const {
    const Vec3 q = turn(p);
    return {middle + scale * (q[0] - centre[0]), middle - scale * (q[1] - centre[1]), q[2]};
  }

  Vec3 right, up, back, centre = {};
  double scale = 1, middle = 0;  // samples per metre, half a tile
};

struct Vertex {
  Vec3 position, colour;  // projected
};

/// A tile's samples: colour and the depth of what is seen.
struct Tile {
  explicit Tile(int edge)
      : edge(edge), colour(size_t(edge) * size_t(edge), kSky), depth(colour.size(), -1e300) {}

  void draw(const Vertex& a, const Vertex& b, const Vertex& c);

  int edge;
  std::vector<Vec3> colour;
  std::vector<double> depth;
};

void Tile::draw(const Vertex& a, const Vertex& b, const Vertex& c) {
  const Vec3 &p = a.position, &q = b.position, &r = c.position;
  const double area = (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]);
  if (area == 0) return;
  const auto clamped = [&](double value) { return int(std::clamp(value, 0.0, double(edge))); };
  const auto first = [&](int d) { return clamped(std::floor(std::min({p[d], q[d], r[d]}))); };
  const auto end = [&](int d) { return clamped(std::ceil(std::max({p[d], q[d], r[d]}))); };
  for (int y = first(1); y < end(1); ++y)
    for (int x = first(0); x < end(0); ++x) {
      const double sx = x + 0.5, sy = y + 0.5;
      const double u = ((q[0] - sx) * (r[1] - sy) - (q[1] - sy) * (r[0] - sx)) / area;
      const double v = ((r[0] - sx) * (p[1] - sy) - (r[1] - sy) * (p[0] - sx)) / area;
      const double w = 1 - u - v, z = u * p[2] + v * q[2] + w * r[2];
      const auto sample = size_t(y) * size_t(edge) + size_t(x);
      if (u < 0 || v < 0 || w < 0 || z <= depth[sample]) continue;
      depth[sample] = z;
      for (int k = 0; k < 3; ++k)
        colour[sample][k] = u * a.colour[k] + v * b.colour[k] + w * c.colour[k];
    }
}

/// A camera that sees every frame, and its shadow on the floor, with a margin of a twelfth.
Camera fit_camera(std::span<const Array<double>> frames, int samples,
                  const ContactSheetOptions& options) {
  Camera camera(options.up);
  Box seen;
  for (const Array<double>& frame : frames)
    for (int64_t n = 0; n < frame.rows(); ++n) {
      Vec3 p = at(frame, n);
      seen.add(camera.turn(p));
      if (options.floor) p[options.up] = *options.floor;
      seen.add(camera.turn(p));
    }
  for (int d = 0; d < 3; ++d) camera.centre[d] = (seen.lower[d] + seen.upper[d]) / 2;
  camera.middle = samples / 2.0;
  camera.scale = samples / (1.2 * std::max({seen.extent(0), seen.extent(1), 1e-12}));
  return camera;
}

/// The body, lit from above the viewer's left shoulder: ambient 0.3 and Lambert 0.7.
void draw_body(Tile& tile, In<double> x, In<int32_t> triangles, In<float> colours,
               const Camera& camera) {
  std::vector<Vec3> normal(size_t(x.rows), Vec3{});
  for (int64_t t = 0; t < triangles.rows; ++t) {
    const int32_t* c = triangles.row(t);
    const Vec3 area = cross(minus(at(x, c[1]), at(x, c[0])), minus(at(x, c[2]), at(x, c[0])));
    for (int k = 0; k < 9; ++k) normal[size_t(c[k / 3])][k % 3] += area[k % 3];
  }
  const Vec3 towards_light = unit({-0.5, 0.8, 0.9});
  std::vector<Vertex> vertices(size_t(x.rows));
  for (int64_t n = 0; n < x.rows; ++n) {
    const Vec3 seen = unit(camera.turn(normal[size_t(n)]));
    const double lit = 0.3 + 0.7 * std::max(0.0, dot(seen, towards_light) * (seen[2] < 0 ? -1 : 1));
    Vertex& vertex = vertices[size_t(n)];
    vertex.position = camera.project(at(x, n));
    for (int k = 0; k < 3; ++k) vertex.colour[k] = lit * colours(n, k);
  }
  const auto vertex = [&](int64_t t, int k) { return vertices[size_t(triangles(t, k))]; };
  for (int64_t t = 0; t < triangles.rows; ++t) tile.draw(vertex(t, 0), vertex(t, 1), vertex(t, 2));
}

/// The floor behind every sample and, a little nearer, the body's vertical shadow.
void draw_ground(Tile& tile, In<double> x, In<int32_t> triangles, const Camera& camera,
                 const ContactSheetOptions& options) {
  for (size_t sample = 0; sample < tile.depth.size(); ++sample) {
    const double y = double(sample / size_t(tile.edge)) + 0.5;
    const double height = camera.centre[1] + (camera.middle - y) / camera.scale;
    tile.depth[sample] =
        (*options.floor - camera.up[options.up] * height) / camera.back[options.up];
    tile.colour[sample] = kGround;
  }
  const auto shadow = [&](int64_t n) {
    Vec3 p = at(x, n);
    p[options.up] = *options.floor;
    Vertex vertex = {camera.project(p), kShadow};
    vertex.position[2] += 1e-3 * tile.edge / camera.scale;
    return vertex;
  };
  for (int64_t t = 0; t < triangles.rows; ++t)
    tile.draw(shadow(triangles(t, 0)), shadow(triangles(t, 1)), shadow(triangles(t, 2)));
}

/// Averages samples into pixels; the last row and column of a tile stay white and part the tiles.
void place(const Tile& tile, int left, int top, int sheet_width, std::vector<uint8_t>& rgb) {
  const int shown = tile.edge / kSamples - 1;
  for (int at = 0; at < 3 * shown * shown; ++at) {
    const int x = at / 3 % shown, y = at / 3 / shown, k = at % 3;
    double sum = 0;
    for (int s = 0; s < kSamples * kSamples; ++s)
      sum += tile.colour[size_t((kSamples * y + s / kSamples) * tile.edge + kSamples * x +
                                s % kSamples)][k];
    rgb[3 * (size_t(top + y) * size_t(sheet_width) + size_t(left + x)) + size_t(k)] =
        uint8_t(std::lround(255 * std::clamp(sum / (kSamples * kSamples), 0.0, 1.0)));
  }
}

void check_input(std::span<const Array<double>> frames, In<int32_t> triangles, In<float> colours,
                 const ContactSheetOptions& options) {
  ELASTOGEN_CHECK(!frames.empty() && options.columns > 0 && options.tile > 0 && options.up >= 0 &&
                      options.up < 3,
                  "a contact sheet needs a frame, positive columns and tile, and up in 0 ... 2");
  const int64_t vertices = frames[0].rows();
  ELASTOGEN_CHECK(colours.is(vertices, 3) && triangles.cols == 3, "colours must be (", vertices,
                  ", 3) and triangles (triangles, 3), got ", colours, " and ", triangles);
  for (const Array<double>& frame : frames)
    ELASTOGEN_CHECK(frame.rows() == vertices && frame.cols() == 3, "frames must be (", vertices,
                    ", 3), got (", frame.rows(), ", ", frame.cols(), ')');
  for (int64_t k = 0; k < triangles.size(); ++k)
    ELASTOGEN_CHECK(triangles.data[k] >= 0 && triangles.data[k] < vertices, "triangle ", k / 3,
                    " names vertex ", triangles.data[k], " of ", vertices);
}

}  // namespace

void write_contact_sheet(const std::string& path, std::span<const Array<double>> frames,
                         In<int32_t> triangles, In<float> colours,
                         const ContactSheetOptions& options) {
  check_input(frames, triangles, colours, options);
  const Camera camera = fit_camera(frames, kSamples * options.tile, options);
  const int columns = std::min(options.columns, int(frames.size()));
  const int rows = (int(frames.size()) + columns - 1) / columns;
  const int width = columns * options.tile, height = rows * options.tile;
  std::vector<uint8_t> rgb(3 * size_t(width) * size_t(height), 255);
  for (int f = 0; f < int(frames.size()); ++f) {
    Tile tile(kSamples * options.tile);
    if (options.floor) draw_ground(tile, frames[size_t(f)], triangles, camera, options);
    draw_body(tile, frames[size_t(f)], triangles, colours, camera);
    place(tile, f % columns * options.tile, f / columns * options.tile, width, rgb);
  }
  write_file(path, encode_png(width, height, rgb));
}

}  // namespace elastogen
