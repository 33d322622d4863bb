// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/obstacles.hpp"

#include "core/parallel.hpp"

#include <cmath>

namespace elastogen::mpm {
namespace {

/// A node that lies on a collider to rounding counts as inside [h].
constexpr double kOn = 1e-9;

enum class Touch { kNone, kSlides, kSticks };

/// Removes the motion into a collider from m, and friction; D is the derivative of the result.
Touch apply(const NodeObstacle& obstacle, Vec3& m, Mat3<double>& D) {
  D = {};
  if (obstacle.sticky) {
    m = obstacle.motion;
    return Touch::kSticks;
  }
  // motion into the collider, and along it
  const Vec3 relative = minus(m, obstacle.motion);
  const double into = -dot(relative, obstacle.normal);
  if (into <= 0) {
    D = identity<double>();
    return Touch::kNone;
  }
  Vec3 along;
  for (size_t a = 0; a < 3; ++a) along[a] = relative[a] + into * obstacle.normal[a];
  // friction stops the motion along it, or shortens it
  const double size = safe_norm(along), limit = obstacle.friction * into;
  m = obstacle.motion;
  if (size <= limit) return obstacle.friction > 0 ? Touch::kSticks : Touch::kSlides;
  const double left = 1 - limit / size;
  // the derivative of sliding
  const Vec3& n = obstacle.normal;
  Vec3 t;
  for (size_t a = 0; a < 3; ++a) t[a] = along[a] / size, m[a] += left * along[a];
  for (size_t a = 0; a < 3; ++a)
    for (size_t b = 0; b < 3; ++b)
      D(int(a), int(b)) = left * ((a == b) - n[a] * n[b] - t[a] * t[b]) + t[a] * t[b] +
                          obstacle.friction * t[a] * n[b];
  return Touch::kSlides;
}

}  // namespace

template <int d>
void ObstacleContact::begin(const ParticleGrid<d>& grid, const std::vector<Obstacle>& obstacles,
                            double time, double dt) {
  const double h = grid.h();
  const auto distance = [&](const Obstacle& obstacle, int64_t i) {
    const std::array<int32_t, 3>& at = grid.place(i);
    const Vec3 x = {at[0] * h, at[1] * h, at[2] * h};
    if (const auto& held = obstacle.held)
      return Proximity{elastogen::distance(*held, x), distance_gradient(*held, x)};
    return proximity(obstacle.collider, offset_at(obstacle.collider, time + dt), x);
  };
  // nodes inside a collider at the end of the step
  std::vector<Vec3> motion;
  for (const Obstacle& obstacle : obstacles)
    motion.push_back(
        minus(offset_at(obstacle.collider, time + dt), offset_at(obstacle.collider, time)));
  node_ = filtered(grid.nodes(), [&](int64_t i) {
    for (const Obstacle& obstacle : obstacles)
      if (distance(obstacle, i).distance <= kOn * h) return true;
    return false;
  });
  // their contacts, node by node
  first_.assign(1, 0);
  obstacle_.clear();
  for (const int32_t i : node_) {
    for (size_t w = 0; w < obstacles.size(); ++w) {
      const Proximity near = distance(obstacles[w], i);
      if (near.distance > kOn * h) continue;
      obstacle_.push_back({near.normal, motion[w], obstacles[w].collider.friction,
                           obstacles[w].sticky || obstacles[w].held});
    }
    first_.push_back(int32_t(obstacle_.size()));
  }
}

Vec3 ObstacleContact::allowed(int64_t k, const Vec3& motion, Mat3<double>* derivative) const {
  Vec3 m = motion;
  Mat3<double> all = identity<double>(), D;
  for (int32_t w = first_[size_t(k)]; w < first_[size_t(k) + 1]; ++w) {
    apply(obstacle_[size_t(w)], m, D);
    all = D * all;
  }
  if (derivative) *derivative = all;
  return m;
}

Mat3<double> ObstacleContact::free_part(int64_t k, const Vec3& motion) const {
  constexpr double kHeld = 1e-12;  // |Q n|^2 of a normal that is held already
  Vec3 m = motion;
  Mat3<double> Q = identity<double>(), D;
  for (int32_t w = first_[size_t(k)]; w < first_[size_t(k) + 1]; ++w) {
    const Touch touch = apply(obstacle_[size_t(w)], m, D);
    if (touch == Touch::kSticks) Q = {};
    if (touch != Touch::kSlides) continue;
    const Vec3& n = obstacle_[size_t(w)].normal;
    Vec3 Qn;
    for (int a = 0; a < 3; ++a) Qn[size_t(a)] = Q(a, 0) * n[0] + Q(a, 1) * n[1] + Q(a, 2) * n[2];
    const double square = dot(Qn, Qn);
    if (square <= kHeld) continue;
    for (size_t a = 0; a < 3; ++a)
      for (size_t b = 0; b < 3; ++b) Q(int(a), int(b)) -= Qn[a] * Qn[b] / square;
  }
  return Q;
}

template void ObstacleContact::begin(const ParticleGrid<2>&, const std::vector<Obstacle>&, double,
                                     double);
template void ObstacleContact::begin(const ParticleGrid<3>&, const std::vector<Obstacle>&, double,
                                     double);

}  // namespace elastogen::mpm
