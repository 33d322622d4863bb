// SPDX-License-Identifier: Apache-2.0
#include "core/ledger.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

/// A force that grows with time, as momentum and as power.
BodyActions at(double t) {
  BodyActions x;
  x.contact.linear = {3 + 2 * t, 0, 0};
  x.damped = 1 + t;
  return x;
}

TEST(Ledger, SecondOrderSchemesIntegrateAForceThatGrowsExactly) {
  StepLedger last;
  last.known = last.opens = true;
  double time = 0, impulse = 0, damped = 0, before = 0;
  for (const double h : {0.5, 0.25, 0.4, 0.3}) {
    const bool by_bdf2 = before > 0 && h != 0.4;
    const TimeStage stage = by_bdf2 ? bdf2_stage(h, before) : sdirk2_stage(1, h);
    StepBooking booking;
    booking.at_first = at(time + kSdirkStage * h);
    booking.at_end = at(time + h);
    last = step_ledger(last, stage, booking);
    time += h, before = h;
    impulse += last.done.contact.linear[0];
    damped += last.done.damped;
    EXPECT_NEAR(impulse, 3 * time + time * time, 1e-14);
    EXPECT_NEAR(damped, time + time * time / 2, 1e-14);
  }
}

TEST(Ledger, TheGuardGoesOnInStepsOfBdf2) {
  // 6 N s are taken in the first step; a third of that is what BDF2 makes of it in the second
  StepLedger first;
  first.known = true;
  first.guarded.linear = {6, 0, 0};
  const StepLedger second = step_ledger(first, bdf2_stage(1, 1), {});
  EXPECT_NEAR(second.guarded.linear[0], 2, 1e-15);
}

TEST(Ledger, AnOpenedLedgerTakesForcesOfTheStepBeforeToBeThoseOfThisOne) {
  StepLedger opened;
  opened.known = opened.opens = true;
  StepBooking booking;
  booking.at_end = at(0);
  EXPECT_NEAR(step_ledger(opened, bdf2_stage(0.5, 0.25), booking).done.contact.linear[0], 1.5,
              1e-15);
  EXPECT_NEAR(step_ledger(opened, euler_stage(0.5), booking).done.contact.linear[0], 1.5, 1e-15);
}

TEST(Ledger, ARunAddsUpAndKnowsItsLargestRise) {
  Ledger run;
  run.add({});  // a step without one
  EXPECT_EQ(run.steps, 0);
  StepLedger step;
  step.known = true;
  double last = 10;
  for (const double energy : {10.0, 6.0, 7.0, 8.5, 3.0}) {
    step.start.energy.kinetic = last, step.end.energy.kinetic = last = energy;
    step.end.momentum.linear = {energy, 0, 0};
    step.done.contact.linear = {0.5, 0, 0};
    run.add(step);
    step.start = step.end;
  }
  EXPECT_EQ(run.steps, 5);
  EXPECT_EQ(run.kinetic, 10);
  EXPECT_EQ(run.linear, 10);
  EXPECT_NEAR(run.rise, 2.5, 1e-15);
  EXPECT_EQ(run.sum.numerical(), 7);
  EXPECT_EQ(run.sum.gap().linear[0], 3 - 2.5);
  EXPECT_EQ(run.linear_gap, 9.5);
}

}  // namespace
}  // namespace elastogen
