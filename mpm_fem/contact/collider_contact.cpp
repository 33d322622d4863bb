// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/contact/collider_contact.hpp"

#include "core/barrier.hpp"
#include "core/error.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen::fem {
namespace {

Vec3 between(const Vec3& a, const Vec3& b, double share) {
  return {a[0] + share * (b[0] - a[0]), a[1] + share * (b[1] - a[1]), a[2] + share * (b[2] - a[2])};
}

}  // namespace

ColliderContact::ColliderContact(ContactPoints points, std::vector<Collider> colliders,
                                 int64_t nodes)
    : points_(std::move(points)) {
  const int64_t count = points_.nodes.rows();
  ELASTOGEN_CHECK(points_.weights.rows() == count && points_.area.rows() == count &&
                      points_.position.rows() == count && points_.stiffness.rows() == count &&
                      points_.weights.cols() == points_.nodes.cols(),
                  "the arrays of the contact points differ in length");
  for (int64_t k = 0; k < points_.nodes.size(); ++k)
    ELASTOGEN_CHECK(points_.nodes.data()[k] >= 0 && points_.nodes.data()[k] < nodes,
                    "contact point ", k / points_.nodes.cols(), " is carried by node ",
                    points_.nodes.data()[k], " of ", nodes);
  for (const Collider& c : colliders) obstacles_.push_back({core_of(c, points_.layer), {}, {}, {}});
  lags_.resize(obstacles_.size() * size_t(count));
  start_.resize(size_t(count));
  if (exists()) stencils_ = stencils_of(points_.nodes);
}

Vec3 ColliderContact::place(In<double> u, int64_t point) const {
  Vec3 x = {points_.position(point, 0), points_.position(point, 1), points_.position(point, 2)};
  for (int a = 0; a < points_.nodes.cols(); ++a)
    for (int i = 0; i < 3; ++i)
      x[size_t(i)] += points_.weights(point, a) * u(points_.nodes(point, a), i);
  return x;
}

void ColliderContact::begin_step(In<double> u, double time, double dt, double share) {
  slip_range_ = share * points_.slip_range;
  bond_ = 0;
  move(u, time, dt);
  set_lags(u, time);
}

/// Notes where points and colliders are at the start of a step, and moves the colliders to its end.
void ColliderContact::move(In<double> u, double time, double dt) {
  for (int64_t p = 0; p < points_.nodes.rows(); ++p) start_[size_t(p)] = place(u, p);
  for (Obstacle& obstacle : obstacles_) {
    obstacle.from = offset_at(obstacle.core, time);
    obstacle.to = obstacle.now = offset_at(obstacle.core, time + dt);
  }
}

/// Takes the normals and the normal forces of friction from displacements u at a time.
void ColliderContact::set_lags(In<double> u, double time) {
  const int64_t count = points_.nodes.rows();
  for (size_t w = 0; w < obstacles_.size(); ++w) {
    const Obstacle& obstacle = obstacles_[w];
    const Vec3 offset = offset_at(obstacle.core, time);
    for (int64_t p = 0; p < count; ++p) {
      const Proximity near = proximity(obstacle.core, offset, place(u, p));
      const double force = -points_.area(p) * points_.stiffness(p) *
                           barrier(near.distance / points_.layer).first / points_.layer;
      lags_[w * size_t(count) + size_t(p)] = {obstacle.core.friction * force, near.normal, {}};
    }
  }
}

void ColliderContact::stand_without_friction(double time, double dt) {
  for (Obstacle& obstacle : obstacles_) {
    obstacle.from = offset_at(obstacle.core, time);
    obstacle.to = obstacle.now = offset_at(obstacle.core, time + dt);
  }
  std::fill(lags_.begin(), lags_.end(), Lag{});
}

void ColliderContact::rub(In<double> u, In<double> mass, double dt, Out<double> v) {
  find_touches(u);
  for (const Touch& t : touches_) {
    const int32_t node = points_.nodes(t.point);
    const double most = t.obstacle->core.friction * push_of(t) * dt / mass(node);
    Vec3 slip;  // velocity along the collider
    for (size_t i = 0; i < 3; ++i)
      slip[i] = v(node, int(i)) - (t.obstacle->to[i] - t.obstacle->from[i]) / dt;
    const double along = dot(slip, t.normal);
    for (size_t i = 0; i < 3; ++i) slip[i] -= along * t.normal[i];
    const double size = norm(slip), share = size > most ? most / size : 1;
    for (size_t i = 0; i < 3; ++i) v(node, int(i)) -= share * slip[i];
  }
}

std::vector<Vec3> ColliderContact::pushes(In<double> u) {
  find_touches(u);
  std::vector<Vec3> sum(obstacles_.size());
  for (const Touch& t : touches_) {
    Vec3& own = sum[size_t(t.obstacle - obstacles_.data())];
    own = plus(own, scaled(t.normal, push_of(t)));
  }
  return sum;
}

void ColliderContact::stand_at(double share) {
  for (Obstacle& obstacle : obstacles_) obstacle.now = between(obstacle.from, obstacle.to, share);
}

double ColliderContact::clear_share(In<double> u, double from) {
  constexpr int kHalvings = 20;
  double share = 1;
  for (int k = 0; k < kHalvings; ++k, share = (share + from) / 2) {
    bool clear = true;
    for (const Obstacle& obstacle : obstacles_)
      for (int64_t p = 0; p < points_.nodes.rows() && clear; ++p) {
        const Vec3 x = place(u, p);
        const double before =
            proximity(obstacle.core, between(obstacle.from, obstacle.to, from), x).distance;
        const double after =
            proximity(obstacle.core, between(obstacle.from, obstacle.to, share), x).distance;
        clear = after >= std::min(before, points_.layer) / 2;
      }
    if (clear) return share;
  }
  return from;
}

/// Distance, normal and slip of a point at a position. Slip is relative to the motion of the
/// collider up to where it stands now (stand_at).
ColliderContact::Touch ColliderContact::touch_of(const Obstacle& obstacle, const Lag& lag,
                                                 int64_t point, const Vec3& x) const {
  const Proximity near = proximity(obstacle.core, obstacle.now, x);
  Touch touch{point, &obstacle, &lag, near.distance, near.normal, {}};
  for (size_t i = 0; i < 3; ++i)
    touch.slip[i] = x[i] - start_[size_t(point)][i] - (obstacle.now[i] - obstacle.from[i]);
  if (bond_ > 0) touch.slip = plus(touch.slip, lag.bond);
  const double along = dot(touch.slip, lag.normal);
  for (size_t i = 0; i < 3; ++i) touch.slip[i] -= along * lag.normal[i];
  return touch;
}

/// Smoothed friction, or that of a bond.
SmoothedSlip ColliderContact::friction_of(const Touch& t) const {
  const double slip = norm(t.slip);
  if (bond_ == 0) return smoothed_slip(slip, slip_range_);
  return elastic_slip(slip, longest_bond(t.point, t.lag->limit));
}

/// Force of the barrier along the normal [N].
double ColliderContact::push_of(const Touch& t) const {
  return -points_.area(t.point) * points_.stiffness(t.point) *
         barrier(t.distance / points_.layer).first / points_.layer;
}

void ColliderContact::find_touches(In<double> u) {
  touches_.clear();
  const int64_t count = points_.nodes.rows();
  for (int64_t p = 0; p < count; ++p) {
    const Vec3 x = place(u, p);
    for (size_t w = 0; w < obstacles_.size(); ++w) {
      const Touch touch = touch_of(obstacles_[w], lags_[w * size_t(count) + size_t(p)], p, x);
      if (touch.distance < points_.layer || touch.lag->limit > 0) touches_.push_back(touch);
    }
  }
}

double ColliderContact::energy(In<double> u) {
  find_touches(u);
  double energy = 0;
  for (const Touch& t : touches_) {
    if (t.distance <= 0) return std::numeric_limits<double>::infinity();
    energy += points_.area(t.point) * points_.stiffness(t.point) *
              barrier(t.distance / points_.layer).value;
    if (t.lag->limit > 0) energy += t.lag->limit * friction_of(t).value;
  }
  return energy;
}

TermValue ColliderContact::value(In<double> u) {
  const double touch = energy(u);
  return {touch, touch, 0};
}

void ColliderContact::add_gradient(In<double> u, Out<double> g) {
  find_touches(u);
  for (const Touch& t : touches_) {
    const double push = -push_of(t);
    const double drag = t.lag->limit > 0 ? t.lag->limit * friction_of(t).first_over_y : 0;
    for (int a = 0; a < points_.nodes.cols(); ++a)
      for (int i = 0; i < 3; ++i)
        g(points_.nodes(t.point, a), i) +=
            points_.weights(t.point, a) * (push * t.normal[size_t(i)] + drag * t.slip[size_t(i)]);
  }
}

/// Second derivative of a point's energy in its position, (3, 3). The projected one of bonds has a
/// tenth of the secant of friction: a bond that yields has no stiffness along its slip, and Newton's
/// step would carry the point through the whole range where it holds.
void ColliderContact::hessian_of(const Touch& t, TangentKind kind, double block[9]) const {
  const double k = points_.area(t.point) * points_.stiffness(t.point) *
                   barrier(t.distance / points_.layer).second / (points_.layer * points_.layer);
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j) block[3 * i + j] = k * t.normal[i] * t.normal[j];
  if (!(t.lag->limit > 0)) return;
  const double y = norm(t.slip);
  const SmoothedSlip f = friction_of(t);
  const double across = t.lag->limit * f.first_over_y;
  double second = t.lag->limit * f.second;
  if (bond_ > 0 && kind == TangentKind::kProjected) second = 0.9 * second + 0.1 * across;
  const double along = y > 0 ? (second - across) / (y * y) : 0;
  const Vec3& n = t.lag->normal;
  for (size_t i = 0; i < 3; ++i)
    for (size_t j = 0; j < 3; ++j)
      block[3 * i + j] +=
          across * ((i == j ? 1.0 : 0.0) - n[i] * n[j]) + along * t.slip[i] * t.slip[j];
}

void ColliderContact::add_hessian(In<double> u, TangentKind kind, SparseMatrix& H) {
  find_touches(u);
  for (const Touch& t : touches_) {
    double point[9], block[9];
    hessian_of(t, kind, point);
    for (int a = 0; a < points_.nodes.cols(); ++a)
      for (int b = 0; b < points_.nodes.cols(); ++b) {
        const double weight = points_.weights(t.point, a) * points_.weights(t.point, b);
        for (int k = 0; k < 9; ++k) block[k] = weight * point[k];
        H.add_block(points_.nodes(t.point, a), points_.nodes(t.point, b), block);
      }
  }
}

double ColliderContact::longest_step(In<double> u, In<double> end) {
  double share = 1;
  for (int64_t p = 0; p < points_.nodes.rows(); ++p) {
    const Vec3 a = place(u, p), b = place(end, p);
    for (const Obstacle& obstacle : obstacles_)
      share = std::min(
          share, free_share(obstacle.core, obstacle.now, a, b, kLeastDistance * points_.layer));
  }
  return share;
}

double ColliderContact::deepest_overlap(In<double> u) {
  find_touches(u);
  double deepest = 0;
  for (const Touch& t : touches_) deepest = std::max(deepest, points_.layer - t.distance);
  return deepest;
}

const Collider* ColliderContact::obstacle(In<double> u) {
  find_touches(u);
  for (const Touch& t : touches_)
    if (t.distance <= 0) return &t.obstacle->core;
  return nullptr;
}

}  // namespace elastogen::fem
