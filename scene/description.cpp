// SPDX-License-Identifier: Apache-2.0
#include "scene/description.hpp"

#include "mpm_fem/materials/solid_presets.hpp"

namespace elastogen {

Method method_of(const RunDescription& run) {
  bool yields = run.yield.index() != 0, granular = is_granular(run.yield);
  for (const MaterialRegion& region : run.regions) {
    yields |= region.yield.index() != 0;
    granular |= is_granular(region.yield);
  }
  if (!yields) return Method::kAuto;
  if (run.method != Method::kAuto) return run.method;
  return granular ? Method::kMpm : Method::kFem;
}

}  // namespace elastogen
