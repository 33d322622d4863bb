// SPDX-License-Identifier: Apache-2.0
// A net beside its law along the loads of material tests, within the box for which its errors are
// stated. The law decides the free sides, so both are compared in the same states.

#pragma once

#include "training/load_path.hpp"

#include <span>
#include <vector>

namespace elastogen {

/// Numbers at each state of a load, from the most compressed to the most stretched.
struct NetCurve {
  LoadPath path = LoadPath::kUniaxial;
  std::vector<double> stretch;                                    ///< of the first axis
  std::vector<double> law_stress, net_stress;                     ///< nominal, along it [E]
  std::vector<double> law_energy, net_energy;                     ///< [E]
  std::vector<double> stress_error, tangent_error, energy_error;  ///< as in FitReport
};

/// Follows a load until the states leave declared_box or the law has none. Steps of the log stretch
/// are equal on each side of rest, which is one of the states.
/// @param weights  of the material's net, (17153). @param steps  on each side.
/// @throws Error (asset) as NeuralMtl; (usage) unless steps is positive.
NetCurve net_curve(const FitMaterial& material, std::span<const float> weights, LoadPath path,
                   int steps = 80);

}  // namespace elastogen
