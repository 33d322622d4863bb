// SPDX-License-Identifier: Apache-2.0
#include "tests/curved/curved_scene.hpp"
#include "tests/support/matrices.hpp"

#include <cmath>
#include <numbers>

namespace elastogen::test {
namespace {

constexpr double kEps = 1e-9;  // [m] about held planes

Material solid(double young) {
  return {
      .name = "solid", .law = Law::kNeoHookean, .young = young, .poisson = 0.3, .density = 1000};
}

std::function<Vec3(const Vec3&)> gravity(const Vec3& g) {
  return [g](const Vec3&) { return g; };
}

/// Holds all components of the material at X_axis <= 0.
auto held_below(size_t axis) {
  return [axis](const Vec3& X, int, double) -> std::optional<double> {
    return X[axis] < kEps ? std::optional(0.0) : std::nullopt;
  };
}

/// [-1, 1] with short cells at its ends.
double graded(double p) {
  return p * (1.3 - 0.3 * p * p);
}

/// A bar 5:1 turned by 0.5 rad about (1, 2, 3) whose part at x < 0 is held, so that what bends
/// begins at an oblique face. Cells are shorter towards the root.
CurvedScene turned_bar() {
  constexpr double kLength = 1, kHalf = 0.1;
  const double s = std::sin(0.25) / std::sqrt(14.0);
  const Mat3<double> R = rotation_of(std::cos(0.25), s, 2 * s, 3 * s);
  CurvedScene scene;
  scene.load = "x < 0 held, bent by its weight";
  scene.body.mirrored = {false, true, true};
  scene.body.cells = {6, 1, 1};
  scene.body.map = [R](const Vec3& p) {
    // along the axis from the plane x = 0 to the end
    const double y = kHalf * graded(p[1]), z = kHalf * graded(p[2]);
    const double begin = -(R(0, 1) * y + R(0, 2) * z) / R(0, 0);
    const double share = p[0] * (0.4 + 0.6 * p[0]);
    const double local[3] = {begin + share * (kLength - begin), y, z};
    Vec3 X = {};
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) X[size_t(i)] += R(i, j) * local[j];
    return X;
  };
  scene.length = kLength;
  for (auto& plane : scene.planes) plane = 0;
  scene.material = solid(7e5);
  scene.acceleration = gravity({0, 0, -9.81});
  scene.held = held_below(0);
  return scene;
}

/// A ball of radius 1 m in a field of forces away from the plane y = 0, which stretch it.
CurvedScene pulled_ball() {
  CurvedScene scene;
  scene.load = "pulled by a body force that grows with y, nothing held";
  scene.body.mirrored = {true, true, true};
  scene.body.map = [](Vec3 p) {
    to_ball(p.data(), 3);
    return p;
  };
  scene.length = 2;
  for (auto& plane : scene.planes) plane = 0;
  scene.octant = true;
  scene.material = solid(1e5);
  scene.acceleration = [](const Vec3& X) { return Vec3{0, 150 * X[1], 0}; };
  scene.held = [](const Vec3&, int, double) { return std::optional<double>(); };
  scene.tets = 4;
  return scene;
}

/// The same pressed towards that plane.
CurvedScene pressed_ball() {
  CurvedScene scene = pulled_ball();
  scene.load = "pressed by a body force that grows with -y, nothing held";
  scene.acceleration = [](const Vec3& X) { return Vec3{0, -200 * X[1], 0}; };
  return scene;
}

/// A bar of 0.4 m one end of which is turned by 90 degrees.
CurvedScene twisted_bar() {
  CurvedScene scene;
  scene.load = "one end held, the other turned by 90 degrees";
  scene.body.mirrored = {true, true, true};
  scene.body.cells = {3, 1, 1};
  scene.body.map = [](const Vec3& p) {
    return Vec3{0.2 * graded(p[0]), 0.05 * graded(p[1]), 0.05 * graded(p[2])};
  };
  scene.length = 0.4;
  for (auto& plane : scene.planes) plane = 0;
  scene.material = solid(1e6);
  scene.acceleration = gravity({});
  scene.held = [](const Vec3& X, int axis, double factor) -> std::optional<double> {
    if (X[0] < -0.2 + kEps) return 0;
    if (X[0] < 0.2 - kEps) return std::nullopt;
    const double angle = factor * std::numbers::pi / 2, c = std::cos(angle), s = std::sin(angle);
    const double x[3] = {X[0], c * X[1] - s * X[2], s * X[1] + c * X[2]};
    return x[axis] - X[size_t(axis)];
  };
  return scene;
}

/// A hook of round section: an arc of 150 degrees that stands on y = 0, thinner towards its end,
/// bent out of its plane and down.
CurvedScene hook() {
  constexpr double kArc = 0.35, kRoot = 0.1, kEnd = 0.06, kAngle = 150 * std::numbers::pi / 180;
  CurvedScene scene;
  scene.load = "foot held, bent by its weight downward and sideways";
  scene.body.mirrored = {true, false, true};
  scene.body.cells = {1, 6, 1};
  scene.body.map = [](const Vec3& p) {
    const double share = p[1] * (0.5 + 0.5 * p[1]), angle = kAngle * share;
    const double radius = kRoot + (kEnd - kRoot) * share;
    double disc[2] = {p[0], p[2]};
    to_ball(disc, 2);
    const double out = kArc + radius * disc[0];
    return Vec3{out * std::cos(angle), out * std::sin(angle), radius * disc[1]};
  };
  scene.length = kArc + kRoot - (kArc + kEnd) * std::cos(kAngle);
  for (auto& plane : scene.planes) plane = 0;
  scene.material = solid(6e5);
  scene.acceleration = gravity({0, -6.94, -6.94});
  scene.held = held_below(1);
  return scene;
}

}  // namespace

const std::map<std::string, CurvedScene>& curved_scenes() {
  static const std::map<std::string, CurvedScene> scenes = {{"turned bar", turned_bar()},
                                                            {"pulled ball", pulled_ball()},
                                                            {"pressed ball", pressed_ball()},
                                                            {"hook", hook()},
                                                            {"twisted bar", twisted_bar()}};
  return scenes;
}

}  // namespace elastogen::test
