// SPDX-License-Identifier: Apache-2.0
// Names of the modes, and the scales of a scene by which a solver chooses.
#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/parallel.hpp"
#include "network/solver.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace elastogen {

std::string_view solver_name(SolverMode mode) {
  constexpr std::string_view kNames[] = {"auto", "quasi", "newton", "paper"};
  return kNames[int(mode)];
}

SolverMode solver_from_name(std::string_view name) {
  for (const SolverMode mode :
       {SolverMode::kAuto, SolverMode::kQuasi, SolverMode::kNewton, SolverMode::kPaper})
    if (solver_name(mode) == name) return mode;
  throw Error(concat("unknown solver '", name, "'; known are auto, quasi, newton, paper"));
}

double reference_force(const Scene& scene) {
  const double sum = ordered_sum(scene.grid.node_count(), [&](int64_t begin, int64_t end) {
    double part = 0;
    for (int64_t n = begin; n < end; ++n)
      if (!scene.pinned(n)) part += scene.mass(n) * scene.mass(n);
    return part;
  });
  return kReferenceGravity * std::sqrt(sum);
}

double courant_number(const Scene& scene) {
  double largest = 0;
  for (const Material& m : scene.materials)
    largest = std::max(largest, scene.dt / scene.grid.h * std::sqrt(m.young / m.density));
  return largest;
}

double float_floor(const Scene& scene) {
  return rounding_floor(scene, std::numeric_limits<float>::epsilon());
}

}  // namespace elastogen
