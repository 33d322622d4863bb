// SPDX-License-Identifier: Apache-2.0
#include "training/net_curve.hpp"

#include "core/error.hpp"
#include "network/law/neural_mtl.hpp"
#include "training/fit_report.hpp"
#include "training/strain_sampler.hpp"

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

/// Loads of a material within the box of its net.
struct Loads {
  TargetLaw law;
  StrainBox box;
  LoadPath path;

  /// The state at a log stretch, if it lies in the box.
  std::optional<LoadState> state(double e) const {
    const auto balanced = balanced_state(law, path, std::exp(e));
    constexpr double kSlack = 1e-12;  // states at the ends belong to the box despite rounding
    if (!balanced || !box.contains(balanced->e.data(), kSlack)) return std::nullopt;
    return balanced;
  }
};

/// Farthest log stretch on one side of rest with a state in the box, by bisection.
double end_of(const Loads& loads, double sign) {
  double inside = 0, outside = sign * loads.box.stretch;
  if (loads.state(outside)) return outside;
  for (int k = 0; k < 50; ++k) {
    const double middle = (inside + outside) / 2;
    (loads.state(middle) ? inside : outside) = middle;
  }
  return inside;
}

std::vector<LoadState> states_of(const Loads& loads, int steps) {
  const double low = end_of(loads, -1), high = end_of(loads, 1);
  std::vector<LoadState> states;
  for (int k = -steps; k <= steps; ++k)
    if (const auto state = loads.state((k < 0 ? -low : high) * k / steps)) states.push_back(*state);
  return states;
}

}  // namespace

NetCurve net_curve(const FitMaterial& material, std::span<const float> weights, LoadPath path,
                   int steps) {
  ELASTOGEN_CHECK(steps > 0, "steps must be positive, got ", steps);
  // states of the law along the load
  const std::vector<LoadState> states =
      states_of({target_law(material), declared_box(material), path}, steps);
  Array<double> e(int64_t(states.size()), 3);
  NetCurve curve;
  curve.path = path;
  for (size_t k = 0; k < states.size(); ++k) {
    std::copy(states[k].e.begin(), states[k].e.end(), e.row(int64_t(k)));
    curve.stretch.push_back(std::exp(states[k].e[0]));
    curve.law_stress.push_back(states[k].stress);
    curve.law_energy.push_back(states[k].energy);
  }
  // the net in these states
  std::vector<LogJet> jets(states.size());
  NeuralMtl(weights, material.poisson).evaluate<false>(e.data(), e.rows(), jets.data());
  for (size_t k = 0; k < states.size(); ++k) {
    curve.net_stress.push_back(jets[k].w[0] / curve.stretch[k]);
    curve.net_energy.push_back(jets[k].psi);
  }
  // errors there
  StrainErrors errors = strain_errors(material, weights, e);
  curve.stress_error = std::move(errors.stress);
  curve.tangent_error = std::move(errors.tangent);
  curve.energy_error = std::move(errors.energy);
  return curve;
}

}  // namespace elastogen
