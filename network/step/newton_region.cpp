// SPDX-License-Identifier: Apache-2.0
#include "network/step/newton_region.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr int kMostFailures = 4;  // to shorten a step by 2^12 and the region after it by 2^6

}  // namespace

double forcing_term(double residual, double before, double last, double target) {
  double eta = 0.1;
  if (before > 0) {
    eta = 0.9 * (residual / before) * (residual / before);
    if (0.9 * last * last > 0.1) eta = std::max(eta, 0.9 * last * last);
    eta = std::min(eta, 0.1);
  }
  return std::max(eta, 0.5 * target / residual);
}

bool NewtonRegion::take_step(const PcgScalars& end, double unit, const StepTaken& step) {
  const bool moved = step.share > 0;
  failures_ = moved ? 0 : failures_ + 1;
  region_.update(end, unit, step);
  bounded_ = bounded_ || end.at_edge || step.halved;
  return moved || (failures_ <= kMostFailures && -step.slope > step.noise);
}

}  // namespace elastogen
