// SPDX-License-Identifier: Apache-2.0
#include "scene/host_stepper.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

bool HostStepper::fits_single() const {
  const Array<double>& x = state_.x;
  const auto fits = [](double value) { return std::abs(value) < kLargestSingle; };
  return std::all_of(x.data(), x.data() + x.size(), fits);
}

}  // namespace elastogen
