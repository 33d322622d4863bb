// SPDX-License-Identifier: Apache-2.0
#include "scene/host_stepper.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {

Array<double> yield_rows(const std::vector<Yield>& yields) {
  Array<double> rows(int64_t(yields.size()), 5);
  for (size_t m = 0; m < yields.size(); ++m) {
    double* row = rows.row(int64_t(m));
    row[0] = double(yields[m].index());
    if (const auto* metal = std::get_if<MetalYield>(&yields[m]))
      row[1] = metal->stress, row[2] = metal->hardening;
    if (const auto* sand = std::get_if<SandYield>(&yields[m]))
      row[1] = sand->friction, row[2] = sand->cohesion, row[3] = sand->keeps_volume;
    if (const auto* snow = std::get_if<SnowYield>(&yields[m])) {
      row[1] = snow->slope, row[2] = snow->cohesion;
      row[3] = snow->hardening, row[4] = snow->pressure;
    }
  }
  return rows;
}

bool HostStepper::fits_single() const {
  const Array<double>& x = state_.x;
  const auto fits = [](double value) { return std::abs(value) < kLargestSingle; };
  return std::all_of(x.data(), x.data() + x.size(), fits);
}

}  // namespace elastogen
