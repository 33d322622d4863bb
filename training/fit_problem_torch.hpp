// SPDX-License-Identifier: Apache-2.0
// Errors of nets against their laws, relative and independent of scale. Fits minimise them, reports
// state them.

#pragma once

#include "training/neural_mtl_torch.hpp"

namespace elastogen {

/// Errors of nets at strains, with M = 2 mu + lambda.
struct BatchErrors {
  at::Tensor stress;   ///< [ |t_theta - t| / (|t| + 1e-4 M) ]^2, (nets, strains)
  at::Tensor tangent;  ///< [ |H_theta - H| / |H| ]^2, Frobenius, (nets, second)
  at::Tensor energy;   ///< (psi_theta - psi) / (psi + 1e-6 M), (nets, strains)
};

/// Materials on a device, with one net each.
class FitProblem {
 public:
  FitProblem(const std::vector<FitMaterial>& materials, at::Device device);

  /// Errors at principal log stretches e, (strains, 3); of the tangent only at the first `second`.
  BatchErrors errors(const MtlNets& nets, const Array<double>& e, int64_t second) const;

 private:
  MtlResponse targets(const Array<double>& e, int64_t second) const;

  at::Device device_;
  int64_t count_;
  MtlAnchors anchors_;
  at::Tensor laws_;     // the bytes of TargetLaw
  at::Tensor modulus_;  // M, (nets, 1)
};

/// The device of that name, "cpu" or "cuda". @throws Error if it is not available.
at::Device fit_device(const std::string& name);

}  // namespace elastogen
