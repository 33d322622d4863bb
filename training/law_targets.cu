// SPDX-License-Identifier: Apache-2.0
#include "core/cuda/launch.cuh"
#include "training/law_targets.hpp"

namespace elastogen::cuda {

void law_targets(const TargetLaw* materials, int64_t count, const double* e, int64_t strains,
                 const LawTargets& to) {
  for_each(count * strains,
           [=] __device__(int64_t k) { write_target(materials, e, strains, k, to); });
}

}  // namespace elastogen::cuda
