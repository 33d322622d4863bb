// SPDX-License-Identifier: Apache-2.0
#include "network/free_flight.hpp"

namespace elastogen {

FreeFlight::FreeFlight(const Scene& scene) : scene_(scene) {
  const int64_t nodes = scene.grid.node_count();
  std::vector<double> mass(size_t(scene.grid.pieces));
  std::vector<uint8_t> held(mass.size());
  for (int64_t n = 0; n < nodes; ++n) held[piece(size_t(n))] |= scene.pinned(n);
  if (std::find(held.begin(), held.end(), 0) == held.end()) return;
  for (int64_t n = 0; n < nodes; ++n) mass[piece(size_t(n))] += scene.mass(n);
  per_mass_.resize(mass.size());
  excess_.resize(mass.size());
  for (size_t p = 0; p < mass.size(); ++p)
    if (!held[p] && mass[p] > 0) per_mass_[p] = 1 / mass[p], exists_ = true;
}

}  // namespace elastogen
