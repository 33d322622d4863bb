// SPDX-License-Identifier: Apache-2.0
// The potential of a finite element scene: the elements of its mesh, its colliders, its mass.

#pragma once

#include "mpm_fem/fem_scene.hpp"
#include "mpm_fem/solve/elastic_term.hpp"
#include "mpm_fem/solve/potential.hpp"

namespace elastogen::fem {

/// The scene must outlive it.
struct FemPotential {
  /// @throws Error as ElasticTerm, MassMatrix, ColliderContact and Potential.
  explicit FemPotential(const FemScene& scene, const LinearOptions& options = {});

  ElasticBody& body() { return elements.body(); }
  const ElasticBody& body() const { return elements.body(); }

  ElasticTerm elements;
  ColliderContact contact;  ///< a term of the potential where it exists
  Potential potential;
};

}  // namespace elastogen::fem
