// SPDX-License-Identifier: Apache-2.0
// What steps of stages (time_stage.hpp) need of a point's contact besides its energy: the slip that
// its bond keeps (network/contact/friction.cpp), and what colliders do to the piece. Shared by host
// and device.

#pragma once

#include "core/point_contact.hpp"

#include <vector>

namespace elastogen {

/// What colliders do to a piece of the body.
struct ContactAction {
  Vec3 force = {};    ///< [N]
  Vec3 torque = {};   ///< about the point asked for [N m]
  double normal = 0;  ///< sum of the sizes of the normal forces [N]
  double power = 0;   ///< of the normal forces [W], relative to the colliders
  double rubbed = 0;  ///< power of sliding against the other forces [W], relative to the colliders
  double driven = 0;  ///< power of the colliders: their forces times their velocities [W]

  void add(const ContactAction& o) {
    force = plus(force, o.force);
    torque = plus(torque, o.torque);
    normal += o.normal;
    power += o.power;
    rubbed += o.rubbed;
    driven += o.driven;
  }
};

/// That of all pieces.
struct ActionSums {
  std::vector<ContactAction> pieces;
  double energy = 0;  ///< of the normal forces [J]
  double bonds = 0;   ///< that bonds would hold, where a step ends there [J]
};

/// What a point adds to them.
struct PointAction {
  ContactAction action;
  double energy = 0, bond = 0;
};

/// Velocities of a point relative to a collider, and that of the collider [m/s].
struct PointSpeeds {
  Vec3 start = {};  ///< at the start of the step, for the power of the normal forces
  Vec3 stage = {};  ///< at the stage, for that of friction
  Vec3 collider = {};
};

/// The part of a bond's slip across the normal that the friction of a lag holds.
/// @param stiffness  of the point [J].
ELASTOGEN_HD inline Vec3 bonded_slip(const ContactLengths& of, double stiffness,
                                     const ContactLag& lag, const Vec3& slip) {
  if (!(lag.limit > 0)) return {};
  const Vec3 across = minus(slip, scaled(lag.normal, dot(slip, lag.normal)));
  const double most = lag.limit / (of.bond * stiffness), size = std::sqrt(dot(across, across));
  return size > most ? scaled(across, most / size) : across;
}

/// The lag that the next solve takes, a share of the way from that of the last solve to that of the
/// positions where it ended: where a solve answers more normal force with less, and the other way
/// round, the whole way would lead to and fro for ever.
ELASTOGEN_HD inline ContactLag relaxed_lag(const ContactLag& last, const ContactLag& end,
                                           double share) {
  const double of_last = (1 - share) * last.limit, of_end = share * end.limit;
  ContactLag result{of_last + of_end, end.normal};
  if (!(of_last > 0)) return result;
  if (!(of_end > 0)) return {of_last, last.normal};
  for (size_t i = 0; i < 3; ++i)
    result.normal[i] = (1 - share) * last.normal[i] + share * end.normal[i];
  const double size = safe_norm(result.normal);
  result.normal = size > 0 ? scaled(result.normal, 1 / size) : end.normal;
  return result;
}

/// The slip that the bond of a point keeps at the end of a step.
ELASTOGEN_HD inline Vec3 kept_slip(const ContactLengths& of, const ContactPoint& point,
                                   const ObstaclePath& path, const ContactLag& lag,
                                   const Proximity& near, double friction) {
  const ContactLag end = contact_lag(near, point.stiffness, friction, of.layer);
  return bonded_slip(of, point.stiffness, end, slip_of(point, path, lag));
}

/// What a collider does to a point that feels it.
/// @param about  point of the torque [m].
ELASTOGEN_HD inline PointAction point_action(const ContactLengths& of, const ContactPoint& point,
                                             const ObstaclePath& path, const ContactLag& lag,
                                             const Proximity& near, double friction,
                                             const Vec3& about, const PointSpeeds& speeds) {
  PointAction result;
  Vec3 gradient;
  point_energy(of, point, path, lag, near, gradient);
  // the force on the body is against the gradient
  result.action.force = scaled(gradient, -1);
  result.action.torque = cross(minus(point.place, about), result.action.force);
  const Curve b = barrier(near.distance / of.layer);
  result.energy = point.stiffness * b.value;
  result.action.normal = -point.stiffness * b.first / of.layer;
  result.action.power = result.action.normal * dot(near.normal, speeds.start);
  const Vec3 across = minus(result.action.force, scaled(near.normal, result.action.normal));
  result.action.rubbed = -dot(across, speeds.stage);
  result.action.driven = dot(result.action.force, speeds.collider);
  const Vec3 kept = kept_slip(of, point, path, lag, near, friction);
  result.bond = of.bond * point.stiffness * dot(kept, kept) / 2;
  return result;
}

}  // namespace elastogen
