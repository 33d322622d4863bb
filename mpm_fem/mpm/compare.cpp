// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/mpm/compare.hpp"

#include "mpm_fem/mpm/p2g.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace elastogen::mpm {
namespace {

using NodeMass = std::map<std::array<int32_t, 3>, double>;

template <int d>
NodeMass node_mass(const Particles& particles, double h) {
  ParticleGrid<d> grid(h);
  grid.update(particles.x);
  Zeroed<double> scratch;
  const NodeMotion nodes = particles_to_grid<d>(grid, particles, scratch);
  NodeMass mass;
  for (int64_t i = 0; i < grid.nodes(); ++i) mass[grid.place(i)] = nodes.mass(i);
  return mass;
}

double largest(const NodeMass& masses) {
  double most = 0;
  for (const auto& [place, mass] : masses) most = std::max(most, mass);
  return most;
}

double at(const NodeMass& masses, const std::array<int32_t, 3>& place) {
  const auto found = masses.find(place);
  return found == masses.end() ? 0 : found->second;
}

double soft(const NodeMass& a, const NodeMass& b) {
  const double most_a = largest(a), most_b = largest(b);
  double both = 0, all = 0;
  for (const auto& [place, mass] : a) {
    both += mass * at(b, place) / (most_a * most_b);
    all += mass / most_a;
  }
  for (const auto& [place, mass] : b) all += mass / most_b;
  return both / (all - both);
}

}  // namespace

Likeness compare(const Particles& a, const Particles& b, int dimension, double h, double full) {
  constexpr double kThere = 0.1;  // of a full node
  const NodeMass A = dimension == 2 ? node_mass<2>(a, h) : node_mass<3>(a, h);
  const NodeMass B = dimension == 2 ? node_mass<2>(b, h) : node_mass<3>(b, h);
  NodeMass places = A;
  places.insert(B.begin(), B.end());
  double least = 0, most = 0;
  int64_t both = 0, either = 0;
  for (const auto& [place, unused] : places) {
    const double mass_a = at(A, place), mass_b = at(B, place);
    least += std::min(mass_a, mass_b);
    most += std::max(mass_a, mass_b);
    both += mass_a > kThere * full && mass_b > kThere * full;
    either += mass_a > kThere * full || mass_b > kThere * full;
  }
  Likeness likeness;
  likeness.iou_weighted = least / most;
  likeness.iou_binary = either > 0 ? double(both) / double(either) : 1;
  likeness.iou_soft = soft(A, B);
  likeness.iou_soft_scaled = likeness.iou_soft / std::sqrt(soft(A, A) * soft(B, B));
  return likeness;
}

}  // namespace elastogen::mpm
