// SPDX-License-Identifier: Apache-2.0
// Which linear systems are solved by factors, and how far the others are iterated.

#pragma once

#include <cstdint>

namespace elastogen::fem {

struct LinearOptions {
  double max_operations = 2e9;      ///< of a factorisation, above which iterations solve
  int64_t max_entries = 4'000'000;  ///< of a matrix, above which no ordering is tried
  int max_iterations = 4000;        ///< of PCG or GMRES
};

}  // namespace elastogen::fem
