// SPDX-License-Identifier: Apache-2.0
#include "training/law_targets.hpp"

#include <ATen/Parallel.h>

namespace elastogen::cpu {

void law_targets(const TargetLaw* materials, int64_t count, const double* e, int64_t strains,
                 const LawTargets& to) {
  at::parallel_for(0, count * strains, 256, [&](int64_t begin, int64_t end) {
    for (int64_t k = begin; k < end; ++k) write_target(materials, e, strains, k, to);
  });
}

}  // namespace elastogen::cpu
