// SPDX-License-Identifier: Apache-2.0
#include "training/strain_sampler.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace elastogen {
namespace {

constexpr double kSmallestRadius = 1e-4;
constexpr double kGentShare = 0.9;  // of the limit: core/elastic_law.hpp leaves the logarithm there

/// The finaliser of splitmix64 (Steele, Lea, Flood 2014): a bijection that mixes all bits.
uint64_t mix(uint64_t z) {
  z += 0x9e3779b97f4a7c15;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
  z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
  return z ^ (z >> 31);
}

/// A point on a sphere. Uniform height and angle give a uniform direction (Archimedes).
Vec3 on_sphere(double radius, double height, double angle) {
  const double z = 2 * height - 1, ring = std::sqrt(1 - z * z);
  const double phi = 2 * std::numbers::pi * angle;
  return {radius * ring * std::cos(phi), radius * ring * std::sin(phi), radius * z};
}

Vec3 strain(const StrainBox& box, uint64_t seed, uint64_t number) {
  for (uint64_t attempt = 0;; ++attempt) {
    const auto u = [&](uint64_t k) { return counted_uniform(seed, number, 3 * attempt + k); };
    Vec3 e;
    if (number % 2 == 0) {
      for (int i = 0; i < 3; ++i) e[i] = box.stretch * (2 * u(i) - 1);
    } else {
      const double range = std::log(box.stretch / kSmallestRadius);
      e = on_sphere(kSmallestRadius * std::exp(range * u(0)), u(1), u(2));
    }
    const double trace = e[0] + e[1] + e[2];
    const double shift = (std::clamp(trace, -box.volume, box.volume) - trace) / 3;
    for (double& component : e) component += shift;
    // the shift may leave a rounding error in the trace, which is not checked again
    if (StrainBox{box.stretch, 2 * box.volume, box.invariant}.contains(e.data())) return e;
  }
}

}  // namespace

bool StrainBox::contains(const double e[3], double slack) const {
  const double trace = e[0] + e[1] + e[2];
  double excess = -3;
  for (int i = 0; i < 3; ++i) {
    if (std::abs(e[i]) > stretch + slack) return false;
    excess += std::exp(2 * (e[i] - trace / 3));
  }
  return std::abs(trace) <= volume + slack && excess <= invariant + 10 * slack;
}

StrainBox declared_box(const FitMaterial& material) {
  return {kDeclaredBox.stretch, kDeclaredBox.volume, kGentShare * least_limit(material)};
}

StrainBox fit_box(std::span<const FitMaterial> materials) {
  StrainBox box = kFitBox;
  for (const FitMaterial& m : materials)
    box.invariant = std::min(box.invariant, kGentShare * least_limit(m));
  return box;
}

double counted_uniform(uint64_t seed, uint64_t number, uint64_t draw) {
  const uint64_t bits = mix(mix(mix(seed) ^ number) ^ draw);
  return (double(bits >> 11) + 0.5) * 0x1p-53;
}

Array<double> sample_strains(const StrainBox& box, uint64_t seed, uint64_t first, int64_t count) {
  Array<double> strains(count, 3);
  for (int64_t s = 0; s < count; ++s) {
    const Vec3 e = strain(box, seed, first + uint64_t(s));
    std::copy(e.begin(), e.end(), strains.row(s));
  }
  return strains;
}

}  // namespace elastogen
