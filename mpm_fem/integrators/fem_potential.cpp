// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/fem_potential.hpp"

#include "core/error.hpp"
#include "mpm_fem/fem/mesh_part.hpp"
#include "mpm_fem/integrators/fem_state.hpp"

#include <algorithm>

namespace elastogen::fem {
namespace {

/// 1 for each material that yields, or that does not.
std::vector<bool> materials_that(bool yield, const FemScene& scene) {
  std::vector<bool> result(scene.materials.size(), !yield);
  for (size_t m = 0; m < scene.yields.size(); ++m)
    result[m] = (scene.yields[m].index() != 0) == yield;
  return result;
}

bool any_yields(const FemScene& scene) {
  const std::vector<bool> yields = materials_that(true, scene);
  for (int64_t e = 0; e < scene.mesh.elements.rows(); ++e) {
    const auto m = size_t(scene.mesh.material(e));
    if (m < yields.size() && yields[m]) return true;
  }
  return false;
}

std::unique_ptr<ElasticTerm> elastic_term(const FemScene& scene) {
  ELASTOGEN_CHECK(scene.yields.empty() || scene.yields.size() == scene.materials.size(),
                  "yields must be one a material or none, got ", scene.yields.size(), " for ",
                  scene.materials.size());
  if (!any_yields(scene)) return std::make_unique<ElasticTerm>(scene.mesh, scene.materials);
  const ElementMesh part = part_of(scene.mesh, materials_that(false, scene));
  if (part.elements.rows() == 0) return nullptr;
  return std::make_unique<ElasticTerm>(part, scene.materials);
}

std::unique_ptr<PlasticTerm> plastic_term(const FemScene& scene) {
  if (!any_yields(scene)) return nullptr;
  std::vector<Solid> solids;
  for (size_t m = 0; m < scene.materials.size(); ++m)
    solids.push_back({scene.materials[m], scene.yields[m]});
  return std::make_unique<PlasticTerm>(part_of(scene.mesh, materials_that(true, scene)), solids);
}

std::unique_ptr<ViscousTerm> viscous_term(const FemScene& scene) {
  if (std::none_of(scene.materials.begin(), scene.materials.end(), is_damped)) return nullptr;
  ELASTOGEN_CHECK(!any_yields(scene), "a scene with materials that yield has no damping");
  return std::make_unique<ViscousTerm>(scene.mesh, scene.materials);
}

MassMatrix mass_of(const FemScene& scene, const ElasticTerm* elastic, const PlasticTerm* plastic) {
  if (!plastic) return MassMatrix(scene, elastic->body());
  return MassMatrix(scene, ElasticBody(scene.mesh, scene.materials));
}

std::vector<Term*> terms_of(Term* elastic, Term* plastic, Term* viscous, ColliderContact& contact) {
  std::vector<Term*> terms;
  for (Term* term : {elastic, plastic, viscous})
    if (term) terms.push_back(term);
  if (contact.exists()) terms.push_back(&contact);
  return terms;
}

}  // namespace

FemPotential::FemPotential(const FemScene& scene, const LinearOptions& options)
    : elastic(elastic_term(scene)),
      plastic(plastic_term(scene)),
      viscous(viscous_term(scene)),
      contact(scene.contact, scene.colliders, scene.mesh.rest.rows()),
      potential(scene.mesh.rest, scene.fixed, mass_of(scene, elastic.get(), plastic.get()),
                terms_of(elastic.get(), plastic.get(), viscous.get(), contact), options,
                Constraint(scene.dependent)),
      scene_(scene) {}

void FemPotential::move_dependent(double time) {
  if (scene_.dependent_motion) potential.set_offset(dependent_offset(scene_, time));
}

EnergyParts FemPotential::energy(In<double> u) const {
  EnergyParts parts;
  if (elastic) parts = elastic->body().energy(u);
  if (!plastic) return parts;
  const StepWork work = plastic->body().work(u);
  parts.elastic += work.elastic;
  parts.plastic = work.plastic;
  return parts;
}

double FemPotential::min_j(In<double> u) const {
  if (!plastic) return elastic->body().min_j(u);
  const double yielding = plastic->body().min_j(u);
  return elastic ? std::min(elastic->body().min_j(u), yielding) : yielding;
}

double FemPotential::length() const {
  if (!plastic) return elastic->length();
  return elastic ? std::max(elastic->length(), plastic->length()) : plastic->length();
}

}  // namespace elastogen::fem
