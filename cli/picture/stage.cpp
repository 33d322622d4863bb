// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/stage.hpp"

#include "cli/picture/subject.hpp"

namespace elastogen {
namespace {

constexpr Vec3 kSky = {0.96, 0.97, 0.98}, kGround = {0.86, 0.87, 0.89}, kWall = {0.78, 0.80, 0.84},
               kObstacle = {0.66, 0.70, 0.76};  // sRGB
constexpr float kShadow = 0.55f;  // share of the light that falls on surfaces facing up
constexpr double kUpright = 0.5;  // cosine from which on a plane is ground

Vec3 row(const Array<double>& x, int64_t r) {
  return {x(r, 0), x(r, 1), x(r, 2)};
}

/// 0 below `low`, 1 above `high`, smooth in between.
float smooth_step(double low, double high, double x) {
  const double t = std::clamp((x - low) / (high - low), 0.0, 1.0);
  return float(t * t * (3 - 2 * t));
}

Vec3 middle(const Box& box) {
  return scaled(plus(box.lower, box.upper), 0.5);
}

}  // namespace

Stage::Stage(const std::vector<Collider>& colliders, const UpAxis& up, const Box& seen)
    : seen_(seen), up_(up_vector(up)), size_(norm(minus(seen.upper, seen.lower))) {
  for (const Collider& c : colliders) {
    if (c.shape == Collider::Shape::kPlane && dot(c.normal, up_) > kUpright)
      grounds_.push_back({&c, c.centre});
    else
      solids_.push_back({&c, collider_mesh(c, seen), {}, {}, {}});
  }
  move(0);
}

void Stage::move(double time) {
  for (Ground& ground : grounds_)
    ground.point = plus(ground.collider->centre, offset_at(*ground.collider, time));
  for (Solid& solid : solids_) solid.offset = offset_at(*solid.collider, time);
}

Vec3 Stage::place(const Solid& solid, int64_t vertex) const {
  return plus(row(solid.mesh.position, vertex), solid.offset);
}

void Stage::add_foot(const Camera& camera, const Vec3& place, Box& box) const {
  for (const Ground& ground : grounds_) {
    const Vec3& n = ground.collider->normal;
    const double height = dot(minus(place, ground.point), n) / dot(up_, n);
    if (height > 0 && height < size_) box.add(camera.turn(minus(place, scaled(up_, height))));
  }
}

void Stage::add_solids(const Camera& camera, Box& box) const {
  for (const Solid& solid : solids_) {
    if (solid.collider->shape == Collider::Shape::kPlane) continue;
    for (int64_t v = 0; v < solid.mesh.position.rows(); ++v) {
      Vec3 p = place(solid, v);
      for (size_t d = 0; d < 3; ++d)
        p[d] = std::clamp(p[d], seen_.lower[d] - 0.3 * size_, seen_.upper[d] + 0.3 * size_);
      box.add(camera.turn(p));
    }
  }
}

void Stage::see(const Camera& camera) {
  camera_ = camera;
  for (Solid& solid : solids_) {
    const int64_t vertices = solid.mesh.position.rows();
    solid.projected = Array<double>(vertices, 3);
    solid.lit.resize(size_t(vertices));
    for (int64_t v = 0; v < vertices; ++v) {
      const Vec3 p = camera.project(place(solid, v)), n = row(solid.mesh.normal, v);
      std::copy(p.begin(), p.end(), solid.projected.row(v));
      solid.lit[size_t(v)] =
          light_on({dot(camera.right, n), dot(camera.up, n), dot(camera.back, n)});
    }
  }
}

void Stage::draw(Canvas& canvas, const Sun* sun) const {
  canvas.light.assign(canvas.light.size(), light_of_srgb(kSky));
  for (const Ground& ground : grounds_) draw_ground(ground, canvas, sun);
  for (const Solid& solid : solids_) draw_solid(solid, canvas, sun);
}

void Stage::draw_ground(const Ground& ground, Canvas& canvas, const Sun* sun) const {
  const Vec3& n = ground.collider->normal;
  const Camera& c = camera_;
  const Vec3 seen = {dot(c.right, n), dot(c.up, n), dot(c.back, n)};
  if (seen[2] < 0.02) return;
  const double offset = dot(minus(ground.point, c.pivot), n);
  const auto height = [&](double across, double above) {
    return (offset - seen[0] * across - seen[1] * above) / seen[2];
  };
  const auto across = [&](double x) { return c.centre[0] + (x - c.middle[0]) / c.scale; };
  const auto above = [&](double y) { return c.centre[1] - (y - c.middle[1]) / c.scale; };
  // light on the ground varies slowly: one value for each pixel
  for (int y = canvas.first; y < canvas.first + canvas.rows; y += kSamples)
    for (int x = 0; x < canvas.width; x += kSamples) {
      const double half = kSamples / 2.0, right = across(x + half), up = above(y + half);
      const Light light = ground_light(
          ground,
          plus(c.pivot, plus(scaled(c.right, right),
                             plus(scaled(c.up, up), scaled(c.back, height(right, up))))),
          sun);
      for (int s = 0; s < kSamples * kSamples; ++s) {
        const int column = x + s % kSamples, row = y + s / kSamples;
        const auto z = float(height(across(column + 0.5), above(row + 0.5)));
        const size_t sample = canvas.sample(column, row);
        if (z <= canvas.depth[sample]) continue;
        canvas.depth[sample] = z;
        canvas.light[sample] = light;
      }
    }
}

Light Stage::ground_light(const Ground& ground, const Vec3& place, const Sun* sun) const {
  static const Light near = light_of_srgb(kGround), far = light_of_srgb(kSky);
  const Vec3& n = ground.collider->normal;
  const Vec3 foot = minus(middle(seen_), scaled(n, dot(minus(middle(seen_), ground.point), n)));
  const float away = smooth_step(0.7 * size_, 2.5 * size_, norm(minus(place, foot)));
  const float lit = 1 - (sun ? kShadow * sun->shadow(place) : 0);
  Light light;
  for (size_t k = 0; k < 3; ++k) light[k] = lit * ((1 - away) * near[k] + away * far[k]);
  return light;
}

void Stage::draw_solid(const Solid& solid, Canvas& canvas, const Sun* sun) const {
  const bool is_plane = solid.collider->shape == Collider::Shape::kPlane;
  const Light colour = light_of_srgb(is_plane ? kWall : kObstacle);
  for (int64_t t = 0; t < solid.mesh.triangles.rows(); ++t) {
    const int32_t* v = solid.mesh.triangles.row(t);
    const Vec3 p = row(solid.projected, v[0]), q = row(solid.projected, v[1]),
               r = row(solid.projected, v[2]);
    // faces seen from behind are not drawn
    if ((q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0]) >= 0) continue;
    fill_triangle(canvas, p, q, r, [&](size_t sample, const Vec3& w, double z) {
      if (float(z) <= canvas.depth[sample]) return;
      canvas.depth[sample] = float(z);
      float lit = 0;
      Vec3 at = {}, normal = {};
      for (size_t c = 0; c < 3; ++c) {
        lit += float(w[c]) * solid.lit[size_t(v[c])];
        at = plus(at, scaled(place(solid, v[c]), w[c]));
        normal = plus(normal, scaled(row(solid.mesh.normal, v[c]), w[c]));
      }
      const double facing = dot(normal, up_);
      if (sun && facing > 0) lit *= 1 - kShadow * float(facing) * sun->shadow(at);
      for (size_t k = 0; k < 3; ++k) canvas.light[sample][k] = lit * colour[k];
    });
  }
}

void Stage::cast(Canvas& canvas) const {
  for (const Solid& solid : solids_) {
    if (solid.collider->shape == Collider::Shape::kPlane) continue;
    for (int64_t t = 0; t < solid.mesh.triangles.rows(); ++t) {
      const int32_t* v = solid.mesh.triangles.row(t);
      fill_triangle(canvas, row(solid.projected, v[0]), row(solid.projected, v[1]),
                    row(solid.projected, v[2]), [&](size_t sample, const Vec3&, double z) {
                      canvas.depth[sample] = std::max(canvas.depth[sample], float(z));
                    });
    }
  }
}

}  // namespace elastogen
