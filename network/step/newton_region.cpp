// SPDX-License-Identifier: Apache-2.0
#include "network/step/newton_region.hpp"

#include <algorithm>

namespace elastogen {
namespace {

constexpr int kCreep = 20;        // Newton steps
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

void NewtonRegion::begin() {
  tangent_ = bounded_ ? TangentKind::kTrue : TangentKind::kProjected;
  region_ = {};
  steps_ = failures_ = 0;
  bounded_ = false;
}

bool NewtonRegion::take_step(const PcgScalars& end, double unit, const StepTaken& step) {
  const bool moved = step.share > 0;
  failures_ = moved ? 0 : failures_ + 1;
  if (tangent_ == TangentKind::kTrue) {
    region_.update(end, unit, step);
    bounded_ = bounded_ || end.at_edge || step.halved;
  } else if (++steps_ == kCreep || !moved) {
    tangent_ = TangentKind::kTrue;
    return true;
  }
  return moved || (failures_ <= kMostFailures && -step.slope > step.noise);
}

}  // namespace elastogen
