// SPDX-License-Identifier: Apache-2.0
// Friction of stages: each point is bonded to each collider that it touches by a spring along the
// surface which yields, elastic and ideally plastic. With s the slip from where the spring would be
// without force,
//
//     force = k_t s  up to  mu N,  then  mu N s/|s|,     k_t = kBond A kappa / D^2,
//
// so a body at rest does not creep, as slip comes back, and friction is no stiffer in short steps.
// At the end of a step what is beyond mu N / k_t is let go for good. mu N and the normal across
// which slip is measured are given within a solve; renew_lags takes them from where it ended.
#include "core/point_contact.hpp"
#include "core/vec3.hpp"
#include "mpm_fem/contact/collider_contact.hpp"

#include <algorithm>

namespace elastogen::fem {

/// The slip mu N / k_t at which a bond yields [m].
double ColliderContact::longest_bond(int64_t point, double limit) const {
  return limit / (bond_ * points_.area(point) * points_.stiffness(point));
}

/// The part of a slip that the friction of a lag holds.
Vec3 ColliderContact::bonded(const Lag& lag, int64_t point, const Vec3& slip) const {
  if (!(lag.limit > 0)) return {};
  const Vec3 along = minus(slip, scaled(lag.normal, elastogen::dot(slip, lag.normal)));
  const double size = norm(along), most = longest_bond(point, lag.limit);
  return size > most ? scaled(along, most / size) : along;
}

/// What the present lags hold of the bonds that the step began with.
void ColliderContact::set_bonds() {
  if (held_.empty()) return;
  const auto count = points_.nodes.rows();
  for (size_t k = 0; k < lags_.size(); ++k) {
    const auto row = int64_t(k);
    lags_[k].bond = bonded(lags_[k], row % count, {held_(row, 0), held_(row, 1), held_(row, 2)});
  }
}

bool ColliderContact::rubs() const {
  return std::any_of(lags_.begin(), lags_.end(), [](const Lag& lag) { return lag.limit > 0; });
}

void ColliderContact::begin_stage(In<double> u, double time, double dt, In<double> lag_u,
                                  double lag_time, In<double> held) {
  bond_ = kBond / (points_.layer * points_.layer);
  held_ = Array<double>(held.rows, 3);
  std::copy(held.data, held.data + held.size(), held_.data());
  end_ = time + dt;
  dt_ = dt;
  move(u, time, dt);
  set_lags(lag_u, lag_time);
  set_bonds();
}

bool ColliderContact::renew_lags(In<double> u) {
  const bool rubbed = rubs();
  last_lags_ = lags_;
  set_lags(u, end_);
  set_bonds();
  return rubbed || rubs();
}

void ColliderContact::relax_lags(double share) {
  for (size_t k = 0; k < lags_.size(); ++k) {
    const Lag& last = last_lags_[k];
    Lag& lag = lags_[k];
    const Vec3 between = plus(scaled(last.normal, 1 - share), scaled(lag.normal, share));
    const double length = norm(between);
    if (!(lag.limit > 0))
      lag.normal = last.normal;
    else if (last.limit > 0 && length > 0)
      lag.normal = scaled(between, 1 / length);
    lag.limit = (1 - share) * last.limit + share * lag.limit;
  }
  set_bonds();
}

Array<double> ColliderContact::bonds(In<double> u) {
  find_touches(u);
  Array<double> held(int64_t(lags_.size()), 3);
  for (const Touch& t : touches_) {
    const Lag end = {t.obstacle->core.friction * push_of(t), t.normal, {}};
    const Vec3 slip = bonded(end, t.point, t.slip);
    std::copy(slip.begin(), slip.end(), held.row(t.lag - lags_.data()));
  }
  return held;
}

/// A field of the nodes at a point.
Vec3 ColliderContact::carried(In<double> field, int64_t point) const {
  Vec3 value = {};
  for (int a = 0; a < points_.nodes.cols(); ++a)
    for (size_t i = 0; i < 3; ++i)
      value[i] += points_.weights(point, a) * field(points_.nodes(point, a), int(i));
  return value;
}

std::vector<PointForce> ColliderContact::forces(In<double> u, In<double> v, In<double> v_stage) {
  find_touches(u);
  std::vector<PointForce> forces;
  for (const Touch& t : touches_) {
    PointForce f;
    f.node = points_.nodes(t.point, 0);
    f.place = place(u, t.point);
    f.push = push_of(t);
    const double kappa = points_.area(t.point) * points_.stiffness(t.point);
    f.energy = kappa * barrier(t.distance / points_.layer).value;
    // forces and their powers
    const double drag = t.lag->limit > 0 ? t.lag->limit * friction_of(t).first_over_y : 0;
    const Vec3 held = scaled(t.slip, -drag),
               speed = scaled(minus(t.obstacle->to, t.obstacle->from), 1 / dt_);
    f.force = plus(scaled(t.normal, f.push), held);
    f.closing = -elastogen::dot(t.normal, minus(carried(v, t.point), speed));
    f.rubbed = -elastogen::dot(held, minus(carried(v_stage, t.point), speed));
    f.driven = elastogen::dot(f.force, speed);
    // what the bond would keep
    const Vec3 kept = bonded({t.obstacle->core.friction * f.push, t.normal, {}}, t.point, t.slip);
    f.bond = bond_ * kappa * elastogen::dot(kept, kept) / 2;
    forces.push_back(f);
  }
  return forces;
}

}  // namespace elastogen::fem
