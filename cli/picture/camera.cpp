// SPDX-License-Identifier: Apache-2.0
#include "cli/picture/camera.hpp"

#include <algorithm>
#include <numbers>

namespace elastogen {
namespace {

constexpr double kMargin = 1.15;  // size of the picture over the size of its contents
// directions towards the viewer in the asset's right, up and front; slightly from above, so that
// the floor is seen as a surface
constexpr Vec3 kTowards[] = {{0.6, 0.45, 1}, {0, 0.18, 1}, {0, 0.18, -1}, {-1, 0.18, 0},
                             {1, 0.18, 0},   {0, 1, 0},    {0.6, 0.45, 1}};

/// Right, up and front of an asset, as viewers of its GLB see it.
struct AssetAxes {
  explicit AssetAxes(const UpAxis& axis) {
    const Matrix4 root = root_matrix(1, axis);
    for (size_t d = 0; d < 3; ++d) {
      right[d] = root[4 * d];
      up[d] = root[4 * d + 1];
      front[d] = root[4 * d + 2];
    }
  }
  Vec3 of(const Vec3& a) const {
    return plus(plus(scaled(right, a[0]), scaled(up, a[1])), scaled(front, a[2]));
  }
  Vec3 right, up, front;
};

Camera looking(const AssetAxes& axes, const Vec3& towards, const Vec3& vertical) {
  Camera camera;
  camera.back = axes.of(scaled(towards, 1 / norm(towards)));
  camera.right = cross(axes.of(vertical), camera.back);
  camera.right = scaled(camera.right, 1 / norm(camera.right));
  camera.up = cross(camera.back, camera.right);
  return camera;
}

}  // namespace

Vec3 Camera::turn(const Vec3& p) const {
  const Vec3 q = minus(p, pivot);
  return {dot(right, q), dot(up, q), dot(back, q)};
}

Vec3 Camera::project(const Vec3& p) const {
  const Vec3 q = turn(p);
  return {middle[0] + scale * (q[0] - centre[0]), middle[1] - scale * (q[1] - centre[1]), q[2]};
}

Camera camera_of(View view, const UpAxis& up, const Vec3& pivot, double turned) {
  Vec3 towards = kTowards[size_t(view)];
  if (view == View::kTurntable) {
    const double angle = 2 * std::numbers::pi * turned, c = std::cos(angle), s = std::sin(angle);
    towards = {c * towards[0] + s * towards[2], towards[1], c * towards[2] - s * towards[0]};
  }
  const bool down = towards[0] == 0 && towards[2] == 0;
  Camera camera = looking(AssetAxes(up), towards, down ? Vec3{0, 0, -1} : Vec3{0, 1, 0});
  camera.pivot = pivot;
  return camera;
}

Camera camera_above(const UpAxis& up, const Vec3& pivot) {
  return camera_of(View::kTop, up, pivot);
}

Vec3 up_vector(const UpAxis& up) {
  return AssetAxes(up).up;
}

void fit(Camera& camera, const Box& box, int width, int height, bool about) {
  for (int d = 0; d < 2; ++d) camera.centre[size_t(d)] = (box.lower[d] + box.upper[d]) / 2;
  double across = box.extent(0);
  if (about) {
    camera.centre[0] = 0;
    across = 2 * std::max(-box.lower[0], box.upper[0]);
  }
  const double deep = box.extent(1), least = 1e-12 * std::max({across, deep, 1e-290});
  camera.middle = {width / 2.0, height / 2.0};
  camera.scale =
      std::min(width / std::max(kMargin * across, least), height / std::max(kMargin * deep, least));
}

}  // namespace elastogen
