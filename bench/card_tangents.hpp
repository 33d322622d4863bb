// SPDX-License-Identifier: Apache-2.0
// The product with the projected Hessian on the device whose tangents are not kept as 45 numbers a
// voxel but made anew in every product, from the nine of F: what `newton` does not do, to measure
// why.

#pragma once

#include "network/potential/incremental_potential_device.hpp"

#include <memory>

namespace elastogen::bench {

class RecomputedHessian {
 public:
  /// On the tables of a potential of laws, which must outlive it.
  explicit RecomputedHessian(cuda::DevicePotential& potential);
  ~RecomputedHessian();

  /// Keeps F_v at u; hessian_product then gives A p as that of the potential does.
  void linearise(const double* u);
  void hessian_product(const float* p, float* product);

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::bench
