// SPDX-License-Identifier: Apache-2.0
// Conjugate gradients for a matrix that need not be definite: they end at the edge of a ball
// (Steihaug 1983, Toint 1981). Lengths |x|_M are in the norm of the inverse M of the
// preconditioner; its products follow from the scalars of the iteration (Conn, Gould, Toint
// 2000, 7.5.1).

#pragma once

#include "core/base.hpp"

#include <cmath>
#include <limits>

namespace elastogen {

/// The scalars of conjugate gradients for A x = b from x = 0, on host and device.
struct PcgScalars {
  static constexpr double kUnbounded = std::numeric_limits<double>::infinity();

  /// Largest |x|_M; 0: ten times the length of the first direction, more than a step needs where A
  /// is convex.
  double radius = kUnbounded;
  double rz = 0, beta = 0, alpha = 0;
  double xx = 0, xp = 0, pp = 0;  ///< x.Mx, x.Mp, p.Mp
  double model = 0;               ///< x.Ax/2 - b.x
  bool begun = false;
  bool ended = false;    ///< the iteration cannot go on from x
  bool at_edge = false;  ///< |x|_M is the radius

  /// Finds beta from r.z, for p = z + beta p.
  ELASTOGEN_HD void turn(double rz_now) {
    beta = begun ? rz_now / rz : 0;
    rz = rz_now;
    xp = beta * xp;
    pp = rz + beta * beta * pp;
    if (radius == 0) radius = 10 * std::sqrt(rz > 0 ? rz : 0);
    begun = true;
  }

  /// Finds alpha from p.Ap, for x += alpha p: the minimum along p, or the edge if the minimum is
  /// beyond it or A is not convex along p; in the latter case 0 if there is no edge.
  ELASTOGEN_HD void advance(double curvature) {
    alpha = 0;
    ended = true;
    if (!(rz > 0) || curvature != curvature) return;
    if (curvature > 0 && !(square_at(rz / curvature) > radius * radius)) {
      alpha = rz / curvature;
      ended = false;
    } else if (radius < kUnbounded) {
      alpha = to_edge();
      at_edge = true;
    }
    model += alpha * (alpha * curvature / 2 - rz);
    xx = square_at(alpha);
    xp += alpha * pp;
  }

 private:
  ELASTOGEN_HD double square_at(double a) const { return xx + a * (2 * xp + a * pp); }
  ELASTOGEN_HD double to_edge() const {
    const double left = xp * xp + pp * (radius * radius - xx);
    return (std::sqrt(left > 0 ? left : 0) - xp) / pp;
  }
};

/// How a step along a direction d from u ended.
struct StepTaken {
  double slope = 0;       ///< Phi'(u) d
  double noise = 0;       ///< of differences of Phi
  double difference = 0;  ///< Phi(u + share d) - Phi(u)
  double share = 0;       ///< of d; 0: Phi did not fall
  bool halved = false;    ///< the whole step, or what obstacles left of it, was too long
};

/// Radius of the ball in which a quadratic model of Phi is trusted.
class TrustRegion {
 public:
  /// 0: not known yet; else in units of `unit`.
  double radius(double unit) const { return radius_ / unit; }

  /// Updates the radius from the end of conjugate gradients, in units of `unit`, and from their
  /// step.
  void update(const PcgScalars& end, double unit, const StepTaken& step) {
    const double length = unit * std::sqrt(end.xx), a = step.share;
    const double predicted = a * (step.slope + a * (unit * unit * end.model - step.slope));
    const double ratio = step.difference / predicted;
    radius_ = unit * end.radius;
    if (a == 0)
      radius_ = length / 64;
    else if (step.halved)
      radius_ = (a > 0.0625 ? a : 0.0625) * length;
    else if (ratio < 0.25)
      radius_ = length / 2;
    else if (ratio > 0.75 && end.at_edge)
      radius_ = 2 * length;
  }

 private:
  double radius_ = 0;
};

}  // namespace elastogen
