// SPDX-License-Identifier: Apache-2.0
// The terms of a scene's incremental potential (incremental_potential.hpp) besides the
// tables of its voxels. Where a device makes its own tables, this is all that the host has.

#pragma once

#include "core/time_scheme.hpp"
#include "network/contact/contact.hpp"
#include "network/law/learned_law.hpp"

#include <cmath>

namespace elastogen {

/// Value of the potential in its parts [J].
struct PotentialValue {
  double inertia = 0, elastic = 0, hourglass = 0, viscous = 0, contact = 0;
  double min_j = 1e300;         ///< smallest det F of a voxel
  double min_corner_j = 1e300;  ///< smallest det F at a corner; only from residual()
  double deepest_overlap = 0;   ///< of a surface point with a collider [m]
  int64_t outside = 0;          ///< voxels with a net at strains outside its box
  double beta = 0;              ///< of damping, as PotentialTerms::beta
  double total() const { return inertia + elastic + hourglass + viscous + contact; }
};

/// 1/k of a step or stage [1/s].
inline double rate_of(const StepScheme& scheme) {
  return std::sqrt(scheme.a0) / scheme.dt;
}

/// Power that damping takes at the end of a step or a stage [W].
inline double damping_power(const PotentialValue& value, const StepScheme& scheme) {
  return 2 * value.viscous * rate_of(scheme);
}

class PotentialTerms {
 public:
  /// @param learned  nets of the scene's materials, by their index; missing or null: analytic.
  /// @throws Error unless each was fitted to the law and the Poisson ratio of its material.
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
  ///     32 eps sum |part| + 4 eps (sqrt(2 S |Phi_elastic|) + sqrt(2 beta S Phi_viscous)),
  ///     S = sum_v W_v (2 mu + lambda):
  ///
  /// stretches are rounded by eps, which changes the elastic energy by a share eps/strain. The
  /// energy of a net may be below 0 at rest by some digits of its table.
  double noise(const PotentialValue& value, double epsilon) const {
    const double elastic = std::abs(value.elastic);
    const double parts = value.total() - value.elastic + elastic;
    return epsilon * (32 * parts + 4 * (std::sqrt(2 * stiffness_ * elastic) +
                                        std::sqrt(2 * value.beta * stiffness_ * value.viscous)));
  }

  bool has_damping() const { return viscous_time_ > 0; }
  /// beta of core/viscous.hpp in a step or stage with 1/k [1/s], the mean over the stiffness of the
  /// materials: damping makes the body 1 + beta times as stiff.
  double beta(double rate) const { return viscous_time_ * rate; }

 protected:
  const Scene& scene_;
  LearnedLaws learned_;
  Contact contact_;
  StepScheme scheme_;

 private:
  double stiffness_;     // S of noise() [J]
  double viscous_time_;  // of the materials, the mean over their stiffness [s]
};

}  // namespace elastogen
