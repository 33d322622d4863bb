// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/fem_potential.hpp"

namespace elastogen::fem {
namespace {

std::vector<Term*> terms_of(ElasticTerm& elements, ColliderContact& contact) {
  std::vector<Term*> terms = {&elements};
  if (contact.exists()) terms.push_back(&contact);
  return terms;
}

}  // namespace

FemPotential::FemPotential(const FemScene& scene, const LinearOptions& options)
    : elements(scene.mesh, scene.materials),
      contact(scene.contact, scene.colliders, scene.mesh.rest.rows()),
      potential(scene.mesh.rest, scene.fixed, MassMatrix(scene, elements.body()),
                terms_of(elements, contact), options) {}

}  // namespace elastogen::fem
