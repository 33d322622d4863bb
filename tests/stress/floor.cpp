// SPDX-License-Identifier: Apache-2.0
#include "tests/stress/floor.hpp"

#include "network/contact/contact.hpp"
#include "tests/network/scenes.hpp"

#include <cmath>
#include <limits>

namespace elastogen::stress {
namespace {

double along(const Vec3& a, const Vec3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

struct Plane {
  bool exists = false;
  Vec3 normal = {};
  double offset = 0, friction = 0;
};

/// The one place that reads the scene's obstacles.
Plane plane_of(const Scene& scene) {
  if (scene.colliders.empty()) return {};
  const Collider& c = scene.colliders[0];
  return {true, c.normal, along(c.normal, c.centre), c.friction};
}

/// Place of a surface point.
Vec3 place(const Scene& scene, const Array<double>& x, int64_t p) {
  Vec3 y = {};
  for (int c = 0; c < 8; ++c)
    for (int i = 0; i < 3; ++i)
      y[size_t(i)] +=
          scene.surface.weights(p, c) * x(scene.grid.corners(scene.surface.voxel(p), c), i);
  return y;
}

double stiffness(const Scene& scene, int64_t p, double D) {
  const Material& m = scene.materials[size_t(scene.material(scene.surface.voxel(p)))];
  return scene.surface.area(p) * m.young * D * D / scene.grid.h;
}

/// b and b' of b(s) = -(1-s)^2 ln s; below s = 1e-3 the parabola that meets it there with both
/// derivatives.
constexpr double kCut = 1e-3;
double log_slope(double s) {
  return 2 * (1 - s) * std::log(s) - (1 - s) * (1 - s) / s;
}
double cut_curvature() {
  const double r = 1 - kCut;
  return 4 * r / kCut - 2 * std::log(kCut) + r * r / (kCut * kCut);
}
double b_value(double s) {
  if (s <= 0) return std::numeric_limits<double>::infinity();
  if (s >= 1) return 0;
  if (s >= kCut) return -(1 - s) * (1 - s) * std::log(s);
  const double d = kCut - s;
  return b_value(kCut) - d * log_slope(kCut) + d * d / 2 * cut_curvature();
}
double b_slope(double s) {
  if (s >= 1) return 0;
  return s >= kCut ? log_slope(s) : log_slope(kCut) - (kCut - s) * cut_curvature();
}

}  // namespace

void put_floor(Scene& scene, double height, double friction) {
  scene.colliders = {half_space({0, 1, 0}, height, friction)};
  scene.surface = test::face_points(scene.grid);
}

double lowest_point(const Scene& scene, const Array<double>& x) {
  const Plane plane = plane_of(scene);
  double lowest = 1e300;
  for (int64_t p = 0; plane.exists && p < scene.surface.voxel.rows(); ++p)
    lowest = std::min(lowest, along(plane.normal, place(scene, x, p)) - plane.offset);
  return lowest;
}

double barrier_energy(const Scene& scene, const Array<double>& x) {
  const Plane plane = plane_of(scene);
  const double D = scene.grid.h / 4;
  double sum = 0;
  for (int64_t p = 0; plane.exists && p < scene.surface.voxel.rows(); ++p) {
    const double d = along(plane.normal, place(scene, x, p)) - plane.offset + D;
    sum += stiffness(scene, p, D) * b_value(d / D);
  }
  return sum;
}

void add_contact_force(const Scene& scene, const Array<double>& x_start, const Array<double>& x,
                       std::vector<double>& force) {
  const Plane plane = plane_of(scene);
  if (!plane.exists) return;
  const double D = scene.grid.h / 4, e = slip_range(scene);
  for (int64_t p = 0; p < scene.surface.voxel.rows(); ++p) {
    const Vec3 y = place(scene, x, p), start = place(scene, x_start, p);
    const double k = stiffness(scene, p, D);
    const double d = along(plane.normal, y) - plane.offset + D;
    const double d_start = along(plane.normal, start) - plane.offset + D;
    const double N = -k * b_slope(d_start / D) / D;
    // slip along the plane
    Vec3 slip, f;
    for (size_t i = 0; i < 3; ++i) slip[i] = y[i] - start[i];
    const double rise = along(slip, plane.normal);
    for (size_t i = 0; i < 3; ++i) slip[i] -= rise * plane.normal[i];
    const double length = std::sqrt(along(slip, slip));
    const double over_y = length < e ? 2 / e - length / (e * e) : 1 / length;
    // barrier and friction
    for (size_t i = 0; i < 3; ++i)
      f[i] = k * b_slope(d / D) / D * plane.normal[i] + plane.friction * N * over_y * slip[i];
    // carried to the corners of the voxel
    for (int c = 0; c < 8; ++c) {
      const int64_t n = scene.grid.corners(scene.surface.voxel(p), c);
      for (int i = 0; i < 3; ++i)
        force[size_t(3 * n + i)] += scene.surface.weights(p, c) * f[size_t(i)];
    }
  }
}

}  // namespace elastogen::stress
