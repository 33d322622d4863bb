// SPDX-License-Identifier: Apache-2.0
#include "core/ledger.hpp"

#include <algorithm>

namespace elastogen {
namespace {

/// The integral over a step of what acts at its stages, and in the step before where that is BDF2's.
BodyActions integral(const TimeStage& last, const StepBooking& booking, const BodyActions& before) {
  BodyActions done;
  done.add(booking.at_end, last.k);
  if (last.t_b > 0) done.add(booking.at_first, last.t - last.k);
  if (last.t_b < 0) done.add(before, -last.w_d);  // J_b - J_0 is that of the step before
  return done;
}

}  // namespace

void TwoMomenta::add(const TwoMomenta& o, double weight) {
  linear = plus(linear, scaled(o.linear, weight));
  angular = plus(angular, scaled(o.angular, weight));
}

void BodyActions::add(const BodyActions& o, double weight) {
  gravity.add(o.gravity, weight);
  contact.add(o.contact, weight);
  pins.add(o.pins, weight);
  loads.add(o.loads, weight);
  colliders += weight * o.colliders;
  moved += weight * o.moved;
  loaded += weight * o.loaded;
  rubbed += weight * o.rubbed;
  damped += weight * o.damped;
  residual += weight * o.residual;
}

TwoMomenta StepLedger::gap() const {
  TwoMomenta left = end.momentum;
  left.add(start.momentum, -1);
  for (const TwoMomenta* known : {&done.gravity, &done.contact, &done.pins, &done.loads, &guarded})
    left.add(*known, -1);
  return left;
}

StepLedger step_ledger(const StepLedger& before, const TimeStage& last,
                       const StepBooking& booking) {
  StepLedger ledger;
  ledger.known = before.known;
  ledger.about = before.about;
  ledger.start = before.end;
  ledger.end = booking.end;
  // of a step before that is not known, forces are taken to have been those of this one
  BodyActions earlier = before.done;
  if (before.opens && last.t_b < 0) earlier.add(booking.at_end, -last.t_b);
  ledger.done = integral(last, booking, earlier);
  ledger.done.pins.add(booking.of_reference, 1);
  // BDF2 goes on with a share of what the guard changed in the step before
  ledger.guarded = booking.end.momentum;
  ledger.guarded.add(booking.corrected.momentum, -1);
  if (last.t_b < 0) ledger.guarded.add(before.guarded, -last.w_d);
  ledger.guard = booking.corrected.energy.kinetic - booking.end.energy.kinetic;
  ledger.correction = booking.corrected.energy.kinetic - booking.kinetic;
  return ledger;
}

void Ledger::add(const StepLedger& step) {
  if (!step.known) return;
  if (steps++ == 0) {
    sum.known = true;
    sum.about = step.about;
    sum.start = step.start;
  }
  sum.end = step.end;
  sum.done.add(step.done, 1);
  sum.guarded.add(step.guarded, 1);
  sum.guard += step.guard;
  sum.correction += step.correction;
  // the largest of a step, and of the momenta and energies that they are held against
  for (const BodyAccount* at : {&step.start, &step.end}) {
    kinetic = std::max(kinetic, at->energy.kinetic);
    linear = std::max(linear, safe_norm(at->momentum.linear));
    angular = std::max(angular, safe_norm(at->momentum.angular));
  }
  const TwoMomenta gap = step.gap();
  linear_gap = std::max(linear_gap, safe_norm(gap.linear));
  angular_gap = std::max(angular_gap, safe_norm(gap.angular));
  // the rise of energy is that above the lowest so far
  lost_ += step.start.energy.total() - step.end.energy.total() + step.work();
  most_lost_ = std::max(most_lost_, lost_);
  rise = std::max(rise, most_lost_ - lost_);
}

}  // namespace elastogen
