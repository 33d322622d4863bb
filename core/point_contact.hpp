// SPDX-License-Identifier: Apache-2.0
// Contact of surface points with colliders: the lengths and the stiffness that every solver uses,
// and energy, force and stiffness of one point at one collider (contact.hpp). An obstacle is the
// core of a collider. Shared by host and device.

#pragma once

#include "core/barrier.hpp"
#include "core/collider_form.hpp"

namespace elastogen {
/// Offsets of a collider at the start and at the end of a step [m].
struct ObstaclePath {
  Vec3 from = {}, to = {};
};

/// Data of friction from the start of the step.
struct ContactLag {
  double limit = 0;  ///< largest force [N], 0: none
  Vec3 normal = {};
};

/// The lengths of a scene's contact [m].
struct ContactLengths {
  double layer = 0;       ///< dhat
  double slip_range = 0;  ///< e of smoothed_slip
  /// Stiffness of friction that holds, over A kappa [1/m^2]; 0: friction is smoothed_slip.
  double bond = 0;
};

/// Stiffness of friction that holds, in units of A E / h.
inline constexpr double kBond = 10;

struct Scene;

/// Depth dhat of the contact layer below a collider's surface, h/4 [m].
double contact_layer(const Scene& scene);

/// Slip within a step [m] up to which friction counts as sticking: a thousandth of the body's
/// free-fall speed times dt, 1e-3 sqrt(g_ref L) dt, L the longest edge of the box around the points
/// of the surface, h at least.
double slip_range(const Scene& scene);

ContactLengths contact_lengths(const Scene& scene);

/// Factor of the barrier of a point, kappa = E dhat^2 / h [N/m], so that a voxel in contact is held
/// with a stiffness of about E h. For E times a point's area it is A kappa [J].
inline double contact_stiffness(double young, double layer, double h) {
  return young * layer * layer / h;
}

/// A point of the surface in a step.
struct ContactPoint {
  Vec3 place = {}, start = {};  ///< now and at the start of the step [m]
  double stiffness = 0;         ///< A kappa [J]
};

/// Stiffness of a point at a collider [N/m]: along the normal; along the slip and across it.
struct PointStiffness {
  double normal = 0, along = 0, across = 0;
  Vec3 n = {}, lagged = {};  ///< normals now and at the start of the step
  Vec3 direction = {};       ///< unit vector of the slip, 0 where there is none

  /// normal n n^T + across (I - m m^T - t t^T) + along t t^T, m the lagged normal.
  ELASTOGEN_HD double entry(size_t i, size_t j) const {
    return normal * n[i] * n[j] + across * ((i == j ? 1 : 0) - lagged[i] * lagged[j]) +
           (along - across) * direction[i] * direction[j];
  }
};

/// Normal and largest friction force, from a point's proximity at the start of the step.
ELASTOGEN_HD inline ContactLag contact_lag(const Proximity& near, double stiffness, double friction,
                                           double layer) {
  const double force =
      near.distance < layer ? -stiffness * barrier(near.distance / layer).first / layer : 0;
  return {friction * force, near.normal};
}

/// Whether a point feels a collider.
ELASTOGEN_HD inline bool touches(const Proximity& near, const ContactLag& lag, double layer) {
  return near.distance < layer || lag.limit > 0;
}

/// Tangential motion of a point relative to a collider since the start of the step.
ELASTOGEN_HD inline Vec3 slip_of(const ContactPoint& point, const ObstaclePath& path,
                                 const ContactLag& lag) {
  Vec3 slip;
  for (size_t i = 0; i < 3; ++i)
    slip[i] = point.place[i] - point.start[i] - (path.to[i] - path.from[i]);
  const double along = dot(slip, lag.normal);
  for (size_t i = 0; i < 3; ++i) slip[i] -= along * lag.normal[i];
  return slip;
}

/// f0 of a point's friction. A bond of stiffness k_t gives way at the slip limit / k_t.
ELASTOGEN_HD inline SmoothedSlip friction_of(const ContactLengths& of, const ContactPoint& point,
                                             double limit, double slip) {
  if (of.bond == 0) return smoothed_slip(slip, of.slip_range);
  return elastic_slip(slip, limit / (of.bond * point.stiffness));
}

/// Energy of a point that feels a collider [J], and its derivative in the point's motion [N].
ELASTOGEN_HD inline double point_energy(const ContactLengths& of, const ContactPoint& point,
                                        const ObstaclePath& path, const ContactLag& lag,
                                        const Proximity& near, Vec3& force) {
  const Curve b = barrier(near.distance / of.layer);
  const double energy = point.stiffness * b.value;
  for (size_t i = 0; i < 3; ++i) force[i] = point.stiffness * b.first / of.layer * near.normal[i];
  if (!(lag.limit > 0)) return energy;
  const Vec3 slip = slip_of(point, path, lag);
  const SmoothedSlip f = friction_of(of, point, lag.limit, safe_norm(slip));
  for (size_t i = 0; i < 3; ++i) force[i] += lag.limit * f.first_over_y * slip[i];
  return energy + lag.limit * f.value;
}

/// Stiffness of a point that feels a collider.
ELASTOGEN_HD inline PointStiffness point_stiffness(const ContactLengths& of,
                                                   const ContactPoint& point,
                                                   const ObstaclePath& path, const ContactLag& lag,
                                                   const Proximity& near) {
  PointStiffness k{.n = near.normal, .lagged = lag.normal};
  k.normal = point.stiffness * barrier(near.distance / of.layer).second / (of.layer * of.layer);
  if (!(lag.limit > 0)) return k;
  k.direction = slip_of(point, path, lag);
  const double size = safe_norm(k.direction);
  const SmoothedSlip f = friction_of(of, point, lag.limit, size);
  k.across = lag.limit * f.first_over_y;
  // a tenth of the secant is added: without it a sliding point would have no stiffness at all, and
  // Newton's step would carry it through the whole range where it sticks
  k.along = lag.limit * (0.9 * f.second + 0.1 * f.first_over_y);
  for (size_t i = 0; i < 3; ++i) k.direction[i] = size > 0 ? k.direction[i] / size : 0;
  return k;
}

/// Whether the motion of a collider halves its distance to a point.
ELASTOGEN_HD inline bool crowded(double before, double after, double layer) {
  return after < layer && after < before / 2;
}

/// Share of a collider's motion that a place near it makes; less where another collider is ahead.
/// Colliders before number `obstacle` have moved already, those after it have not.
/// @tparam Obstacle  an ObstaclePath with a ColliderForm `core`.
template <class Obstacle>
ELASTOGEN_HD double carried_share(const Obstacle* obstacles, size_t count, size_t obstacle,
                                  const Vec3& place, const Vec3& direction) {
  const double own =
      std::max(proximity(obstacles[obstacle].core, obstacles[obstacle].from, place).distance, 0.0);
  double share = 1;
  for (size_t w = 0; w < count; ++w) {
    if (w == obstacle) continue;
    const Proximity near =
        proximity(obstacles[w].core, w < obstacle ? obstacles[w].to : obstacles[w].from, place);
    double ahead = 0;
    for (size_t d = 0; d < 3; ++d) ahead -= direction[d] * near.normal[d];
    const double other = std::max(near.distance, 0.0), sum = other + own * ahead;
    if (ahead > 0 && sum > 0) share = std::min(share, other / sum);
  }
  return share;
}

}  // namespace elastogen
