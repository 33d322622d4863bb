// SPDX-License-Identifier: Apache-2.0
#include "core/ledger.hpp"

namespace elastogen {

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
  for (const TwoMomenta* known :
       {&done.gravity, &done.contact, &done.pins, &done.loads, &guarded})
    left.add(*known, -1);
  return left;
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
    largest_kinetic = std::max(largest_kinetic, at->energy.kinetic);
    largest_linear = std::max(largest_linear, safe_norm(at->momentum.linear));
    largest_angular = std::max(largest_angular, safe_norm(at->momentum.angular));
  }
  const TwoMomenta gap = step.gap();
  largest_gap_of_a_step = std::max(largest_gap_of_a_step, safe_norm(gap.linear));
  largest_angular_gap = std::max(largest_angular_gap, safe_norm(gap.angular));
  // the rise of energy is that above the lowest so far
  lost_ += step.start.energy.total() - step.end.energy.total() + step.work();
  most_lost_ = std::max(most_lost_, lost_);
  largest_rise = std::max(largest_rise, most_lost_ - lost_);
}

BodyActions done_in_step(const TimeStage& last, const BodyActions& at_first,
                         const BodyActions& at_end, const BodyActions& before) {
  BodyActions done;
  done.add(at_end, last.k);
  if (last.t_b > 0) done.add(at_first, last.t - last.k);
  if (last.t_b < 0) done.add(before, -last.w_d);  // J_b - J_0 is that of the step before
  return done;
}

}  // namespace elastogen
