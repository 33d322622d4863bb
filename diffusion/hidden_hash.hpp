// SPDX-License-Identifier: Apache-2.0
// A last layer fits only the hidden layers on which it was found. A hash identifies these.

#pragma once

#include "core/error.hpp"
#include "core/hash.hpp"
#include "training/fit_material.hpp"

#include <span>

namespace elastogen {

/// SHA-256 of the hidden layers within weights, (17153): the bytes of all but the last 129.
/// @throws Error (usage) for another number of weights.
inline std::string hidden_hash(std::span<const float> weights) {
  ELASTOGEN_CHECK(int64_t(weights.size()) == kMtlParameters, "a NeuralMTL has ", kMtlParameters,
                  " weights, not ", weights.size());
  return hex(sha256({reinterpret_cast<const char*>(weights.data()),
                     (weights.size() - kMtlLast) * sizeof(float)}));
}

}  // namespace elastogen
