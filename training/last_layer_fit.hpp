// SPDX-License-Identifier: Apache-2.0
// Fits the last layer of a NeuralMTL to a material, with given hidden layers. At each strain q is
// linear in the 128 weights w of that layer, q = q_0 + Phi w, so stress, tangent and energy are
// quadratic in w, and Levenberg-Marquardt needs less than a second where a gradient method on all
// weights needs minutes. The ten residuals at a strain are relative and independent of scale, with
// M = 2 mu + lambda:
//
//   (t_theta - t)_m / (|t| + 1e-4 M)
//   sqrt(0.1) (H_theta - H)_mn / |H|, sqrt(2) times beside the diagonal
//   sqrt(0.1) (psi_theta - psi) / (psi + 1e-6 M)
//
// so that their squares sum to the loss of fit_neural_mtl.hpp. In double. The hidden layers do not
// change, so all materials with the same hidden layers lie in one space of dimension 128.

#pragma once

#include "core/array.hpp"
#include "training/fit_material.hpp"
#include "training/strain_sampler.hpp"

#include <functional>
#include <span>
#include <vector>

namespace elastogen {

struct LastLayerOptions {
  int iterations = 80;      ///< at most; it ends when ten of them gain less than 2 % together
  double enough = 0;        ///< it ends below this error
  int64_t strains = 2048;   ///< strains in the box
  uint64_t seed = 2;        ///< seed of the strains
  StrainBox box = kFitBox;  ///< fit_box of the materials that will be fitted
};

struct LastLayerFit {
  std::vector<float> weights;  ///< (17153), with the given hidden layers
  double error = 0;            ///< root of the mean over strains of the sum of squares
  int iterations = 0;
};

/// Called after each iteration with their number and the present last layer, (128).
using FitWatch = std::function<void(int iterations, std::span<const double> w)>;

class LastLayer {
 public:
  /// @param weights  of a NeuralMTL, (17153); the hidden layers are kept, the last layer is
  ///                 ignored.
  /// @throws Error (usage) unless there are 17153 weights, and iterations and strains are positive.
  LastLayer(std::span<const float> weights, const LastLayerOptions& options = {});

  /// @param start  last layer at the start, (128); empty: zeros, for which q is linear in the log
  ///               stretches (Hencky's law).
  /// @throws Error (usage) for a start of another size.
  LastLayerFit fit(const FitMaterial& material, std::span<const float> start = {},
                   const FitWatch& watch = {}) const;

  /// Mean of J^T J over the strains of the fit, (128, 128), with J the derivatives in w of the
  /// three residuals of the stress. dw^T (J^T J) dw is the mean square of the relative change of
  /// stress that a small dw makes.
  /// @throws Error (usage) for a last layer of another size.
  Array<double> stress_metric(const FitMaterial& material, std::span<const double> w) const;

  /// q of a material's net with last layer w at the strains of the fit, with the derivatives in e
  /// that the residuals need: (strains, 30), entry 3 c + i is channel c of axis i. Channels are the
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
