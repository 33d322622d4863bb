// SPDX-License-Identifier: Apache-2.0
// What the incremental potential of a scene (network/potential/incremental_potential.hpp) is made of beside
// tables of its voxels: all that the host has of it where a device makes its own.

#pragma once

#include "core/time_scheme.hpp"
#include "network/contact/contact.hpp"
#include "network/law/learned_law.hpp"

#include <cmath>

namespace elastogen {

/// Value of the potential in its parts [J].
struct PotentialValue {
  double inertia = 0, elastic = 0, hourglass = 0, contact = 0;
  double min_j = 1e300;         ///< smallest det F of a voxel
  double min_corner_j = 1e300;  ///< smallest det F at a corner; only from residual()
  double deepest_overlap = 0;   ///< of a surface point with a collider [m]
  int64_t outside = 0;          ///< voxels whose net was asked outside its box
  double total() const { return inertia + elastic + hourglass + contact; }
};

class PotentialTerms {
 public:
  /// @param learned  nets of the scene's materials, by their index; missing or null: analytic.
  /// @throws Error unless each is one of its material's law and Poisson ratio.
  explicit PotentialTerms(const Scene& scene, LearnedLaws learned = {},
                          const StepScheme& scheme = {});

  const Scene& scene() const { return scene_; }
  /// Net of a material, null: analytic.
  const LearnedLaw* learned(size_t material) const { return learned_[material].get(); }
  const Contact& contact() const { return contact_; }
  Contact& contact() { return contact_; }
  const StepScheme& scheme() const { return scheme_; }

  /// Bound on the rounding error of a value of Phi [J], for line searches,
  ///
  ///     32 eps sum |part| + 4 eps sqrt(2 S |Phi_elastic|),   S = sum_v W_v (2 mu + lambda):
  ///
  /// stretches are rounded by eps, which is eps/strain of the elastic energy. That of a net may be
  /// some digits of its table below 0 at rest.
  double noise(const PotentialValue& value, double epsilon) const {
    const double elastic = std::abs(value.elastic);
    const double parts = value.total() - value.elastic + elastic;
    return epsilon * (32 * parts + 4 * std::sqrt(2 * stiffness_ * elastic));
  }

 protected:
  const Scene& scene_;
  LearnedLaws learned_;
  Contact contact_;
  StepScheme scheme_;

 private:
  double stiffness_;  // S of noise() [J]
};

}  // namespace elastogen
