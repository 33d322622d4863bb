// SPDX-License-Identifier: Apache-2.0
#include "network/step/free_flight.hpp"

#include "core/parallel.hpp"

namespace elastogen {

std::vector<uint8_t> held_pieces(const Scene& scene) {
  std::vector<uint8_t> held(size_t(scene.grid.pieces));
  for (const int32_t n :
       filtered(scene.grid.node_count(), [&](int64_t n) { return scene.pinned(n); }))
    held[size_t(scene.grid.piece(n))] = 1;
  for (int64_t k = 0; k < scene.fixed.size(); ++k)
    if (scene.fixed.data()[k] >= 0) held[size_t(scene.grid.piece(k / 3))] = 1;
  return held;
}

std::vector<std::vector<int32_t>> free_pieces(const Scene& scene) {
  const std::vector<uint8_t> held = held_pieces(scene);
  std::vector<int32_t> place(held.size(), -1);
  int32_t count = 0;
  for (size_t p = 0; p < held.size(); ++p)
    if (!held[p]) place[p] = count++;
  if (count == 0) return {};
  return grouped(scene.grid.node_count(), size_t(count),
                 [&](int64_t n) { return place[size_t(scene.grid.piece(n))]; });
}

FreeFlight::FreeFlight(const Scene& scene) : scene_(scene) {
  const std::vector<uint8_t> held = held_pieces(scene);
  if (std::find(held.begin(), held.end(), 0) == held.end()) return;
  std::vector<double> mass(held.size());
  for (int64_t n = 0; n < scene.grid.node_count(); ++n) mass[piece(size_t(n))] += scene.mass(n);
  per_mass_.resize(mass.size());
  excess_.resize(mass.size());
  for (size_t p = 0; p < mass.size(); ++p)
    if (!held[p] && mass[p] > 0) per_mass_[p] = 1 / mass[p], exists_ = true;
}

}  // namespace elastogen
