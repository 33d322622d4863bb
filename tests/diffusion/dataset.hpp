// SPDX-License-Identifier: Apache-2.0
// A small dataset whose last layers and errors are made up, for tests that need no fits.

#pragma once

#include "diffusion/material_family.hpp"
#include "diffusion/weight_dataset.hpp"
#include "training/strain_sampler.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen::test {

/// Hidden layers drawn at random, within 1/sqrt(inputs).
inline std::vector<float> some_hidden() {
  std::vector<float> weights;
  for (uint64_t k = 0; k < uint64_t(kMtlParameters); ++k)
    weights.push_back(float((2 * counted_uniform(7, 1, k) - 1) / std::sqrt(k < 512 ? 3.0 : 128.0)));
  std::fill(weights.end() - kMtlLast, weights.end(), 0.0f);
  return weights;
}

/// Materials 0 ... count - 1 of seed 3, layers and errors numbers of (material, place).
inline WeightDataset some_dataset(int64_t count) {
  std::vector<FitMaterial> materials;
  for (int64_t n = 0; n < count; ++n) materials.push_back(family_material(3, uint64_t(n)));
  WeightDataset data = empty_dataset(some_hidden(), std::move(materials));
  const auto fill = [](auto* values, int64_t size, uint64_t seed) {
    for (int64_t k = 0; k < size; ++k)
      values[k] = std::remove_reference_t<decltype(*values)>(counted_uniform(seed, uint64_t(k), 0));
  };
  fill(data.layers.data(), data.layers.size(), 1);
  fill(data.errors.data(), data.errors.size(), 2);
  fill(data.rms.data(), count, 3);
  for (int64_t n = 0; n < count; ++n) data.iterations[size_t(n)] = int32_t(10 + n);
  return data;
}

}  // namespace elastogen::test
