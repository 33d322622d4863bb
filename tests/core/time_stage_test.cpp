// SPDX-License-Identifier: Apache-2.0
// Stages of a step against the oscillator, whose solution is known.
#include "core/time_scheme.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

/// Position and velocity of x'' = g - omega^2 x.
struct DrivenOscillator {
  double x = 1, v = 0.3, omega = 2, g = 0.7;

  DrivenOscillator after(double t) const {
    DrivenOscillator end = *this;
    const double rest = g / (omega * omega), c = std::cos(omega * t), s = std::sin(omega * t);
    end.x = rest + (x - rest) * c + v / omega * s;
    end.v = v * c - omega * (x - rest) * s;
    return end;
  }
};

/// The end of a stage from `from`, with another point beside it; z = x0.
DrivenOscillator solved(const TimeStage& s, const DrivenOscillator& from,
                        const DrivenOscillator& other) {
  const double d_b = other.x - from.x;
  const double predicted = s.w_d * d_b + s.w_e * other.v + s.w_0 * from.v + s.k * s.k * from.g;
  // the minimum of (d - predicted)^2 / (2 k^2) + omega^2 (x0 + d)^2 / 2
  const double w = s.k * s.k * from.omega * from.omega;
  const double d = (predicted - w * from.x) / (1 + w);
  DrivenOscillator end = from;
  end.x = from.x + d;
  end.v = (d - s.w_v * d_b) / s.k;
  return end;
}

DrivenOscillator sdirk2(const DrivenOscillator& from, double h) {
  const DrivenOscillator a = solved(sdirk2_stage(0, h), from, from);
  return solved(sdirk2_stage(1, h), from, a);
}

double gap(const DrivenOscillator& a, const DrivenOscillator& b) {
  return std::hypot(a.x - b.x, (a.v - b.v) / a.omega);
}

/// Error after a second of steps whose lengths go up and down by a third.
double error_of(TimeScheme scheme, int steps) {
  DrivenOscillator before, now;
  double t = 0, h_before = 0;
  for (int k = 0; k < steps; ++k) {
    const double h = (k % 2 == 0 ? 4.0 / 3 : 2.0 / 3) / steps;
    DrivenOscillator next;
    if (scheme == TimeScheme::kEuler)
      next = solved(euler_stage(h), now, now);
    else if (scheme == TimeScheme::kSdirk2 || k == 0)
      next = sdirk2(now, h);
    else
      next = solved(bdf2_stage(h, h_before), now, before);
    before = now, now = next;
    t += h, h_before = h;
  }
  return gap(now, DrivenOscillator().after(t));
}

TEST(TimeStage, SchemesHaveTheirOrderAtStepsOfChangingLength) {
  for (const auto& [scheme, order] :
       {std::pair{TimeScheme::kEuler, 1.0}, {TimeScheme::kBdf2, 2.0}, {TimeScheme::kSdirk2, 2.0}}) {
    const double found = std::log2(error_of(scheme, 80) / error_of(scheme, 160));
    EXPECT_NEAR(found, order, 0.1) << scheme_name(scheme);
  }
}

TEST(TimeStage, AParabolaIsExactBySchemesOfOrderTwo) {
  DrivenOscillator fall;
  fall.omega = 1e-9;
  const auto exact = [&](double t) {
    DrivenOscillator end = fall;
    end.x += fall.v * t + fall.g * t * t / 2, end.v += fall.g * t;
    return end;
  };
  const double h = 0.4;
  const DrivenOscillator by_sdirk = sdirk2(fall, h);
  EXPECT_NEAR(by_sdirk.x, exact(h).x, 1e-15);
  EXPECT_NEAR(by_sdirk.v, exact(h).v, 1e-15);
  const DrivenOscillator by_bdf = solved(bdf2_stage(h, 0.3), fall, exact(-0.3));
  EXPECT_NEAR(by_bdf.x, exact(h).x, 1e-15);
  EXPECT_NEAR(by_bdf.v, exact(h).v, 1e-15);
}

TEST(TimeStage, Bdf2OfEqualStepsIsThatOfTheFixedScheme) {
  const TimeStage s = bdf2_stage(0.1, 0.1);
  EXPECT_NEAR(s.k * s.k, 0.1 * 0.1 / 2.25, 1e-17);
  const StepScheme fixed(TimeScheme::kBdf2, 0.1, 2.25);
  const double predicted = predicted_motion(fixed, 2, 0.3, 1.9, 0.5, -9.81);
  EXPECT_NEAR(s.w_d * (1.9 - 2) + s.w_e * 0.5 + s.w_0 * 0.3 + s.k * s.k * -9.81, predicted, 1e-15);
}

TEST(TimeStage, AmplitudeKeptIsThatOfTheSchemes) {
  // what a vibration loses in a step, from the formulas of the stages
  for (const double turn : {0.2, 0.8}) {
    DrivenOscillator now;
    now.g = 0, now.omega = turn, now.v = 0;
    const int steps = 400;
    for (int k = 0; k < steps; ++k) now = sdirk2(now, 1);
    const double kept = std::pow(std::hypot(now.x, now.v / turn), 1.0 / steps);
    // steps a period, by the turn of the scheme: close to that of the vibration
    const double per_period = amplitude_kept(TimeScheme::kSdirk2, turn);
    EXPECT_NEAR(std::log(per_period) / std::log(kept), 2 * std::numbers::pi / turn,
                0.04 * 2 * std::numbers::pi / turn);
  }
  // of a table of linear theory: periods of 4 and 8 steps
  EXPECT_NEAR(amplitude_kept(TimeScheme::kSdirk2, std::numbers::pi / 2), 0.94, 0.006);
  EXPECT_NEAR(amplitude_kept(TimeScheme::kSdirk2, std::numbers::pi / 4), 0.99, 0.0015);
}

}  // namespace
}  // namespace elastogen
