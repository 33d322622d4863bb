// SPDX-License-Identifier: Apache-2.0
// The product with the projected Hessian on the device, without storing 45 numbers of the tangent
// for each voxel: every product computes them again from the nine numbers of F. `newton` stores
// them; this measures why.

#pragma once

#include "network/potential/incremental_potential_device.hpp"

#include <memory>

namespace elastogen::bench {

class RecomputedHessian {
 public:
  /// Uses the tables of a potential of laws, which must outlive it.
  explicit RecomputedHessian(cuda::DevicePotential& potential);
  ~RecomputedHessian();

  /// Stores F_v at u. hessian_product then gives A p as the potential does.
  void linearise(const double* u);
  void hessian_product(const float* p, float* product);

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::bench
