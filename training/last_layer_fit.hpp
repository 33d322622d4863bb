// SPDX-License-Identifier: Apache-2.0
// Fits the last layer of a NeuralMTL to a material, its hidden layers given. In the 128 weights w
// of that layer the strains are linear, q = q_0 + Phi w, so stress, tangent and energy are
// quadratic in w, and Levenberg-Marquardt takes less than a second where a gradient method on all
// weights takes minutes. The ten residuals at a strain are relative and without a scale, with
// M = 2 mu + lambda:
//
//   (t_theta - t)_m / (|t| + 1e-4 M)
//   sqrt(0.1) (H_theta - H)_mn / |H|, sqrt(2) times beside the diagonal
//   sqrt(0.1) (psi_theta - psi) / (psi + 1e-6 M)
//
// so that their squares sum to the loss of fit_neural_mtl.hpp. In double. The hidden layers do not
// change: weights of all materials with the same ones lie in one space of 128 dimensions.

#pragma once

#include "core/array.hpp"
#include "training/fit_material.hpp"
#include "training/strain_sampler.hpp"

#include <functional>
#include <span>
#include <vector>

namespace elastogen {

struct LastLayerOptions {
  int iterations = 80;      ///< at most; it ends when ten together gain less than 2 %
  double enough = 0;        ///< it ends below this error
  int64_t strains = 2048;   ///< of the box
  uint64_t seed = 2;        ///< of the strains
  StrainBox box = kFitBox;  ///< fit_box of the materials to come
};

struct LastLayerFit {
  std::vector<float> weights;  ///< (17153), the hidden layers those given
  double error = 0;            ///< root of the mean over strains of the sum of squares
  int iterations = 0;
};

/// Told after each iteration: how many there were, and the last layer now, (128).
using FitWatch = std::function<void(int iterations, std::span<const double> w)>;

class LastLayer {
 public:
  /// @param weights  of a NeuralMTL, (17153); the hidden layers are fixed, the last is ignored.
  /// @throws Error (usage) unless there are 17153 weights, and iterations and strains are positive.
  LastLayer(std::span<const float> weights, const LastLayerOptions& options = {});

  /// @param start  last layer to begin from, (128); empty: zeros, where q is linear in the log
  ///               stretches, Hencky's law.
  /// @throws Error (usage) for a start of another size.
  LastLayerFit fit(const FitMaterial& material, std::span<const float> start = {},
                   const FitWatch& watch = {}) const;

  /// Mean over the strains of the fit of J^T J, (128, 128), with J the derivatives in w of the
  /// three residuals of the stress: dw^T of it dw is the mean square of the relative change of the
  /// stress that a small dw makes.
  /// @throws Error (usage) for a last layer of another size.
  Array<double> stress_metric(const FitMaterial& material, std::span<const double> w) const;

  /// q of material's net at the strains of the fit for a last layer w, with derivatives in e, as
  /// the residuals take them: (strains, 30), entry 3 c + i is channel c of axis i; channels are the
  /// value, 3 first and 6 second derivatives 00 11 22 01 12 20.
  Array<double> strains(const FitMaterial& material, std::span<const double> w) const;
  const Array<double>& points() const { return e_; }  ///< log stretches, (strains, 3)

 private:
  LastLayerOptions options_;
  std::vector<float> weights_;
  Array<double> e_;         // (strains, 3)
  Array<double> inputs_;    // (strains, 30 * 2): the first two inputs, derivatives in e
  Array<double> features_;  // Phi, (strains * 30, 128)
};

}  // namespace elastogen
