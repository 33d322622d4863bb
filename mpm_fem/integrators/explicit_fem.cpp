// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/explicit_fem.hpp"

#include "core/error.hpp"

#include <cmath>

namespace elastogen::fem {

ExplicitFem::ExplicitFem(const FemScene& scene)
    : scene_(scene), terms_(scene), gradient_(scene.mesh.rest.rows(), 3) {
  ELASTOGEN_CHECK(scene.dt > 0 && std::isfinite(scene.dt), "dt must be positive, got ", scene.dt);
  ELASTOGEN_CHECK(scene.mass_kind == Mass::kLumped, "explicit steps take a lumped mass");
  ELASTOGEN_CHECK(!terms_.viscous, "explicit steps have no damping");
  ELASTOGEN_CHECK(!scene.in_wind, "explicit steps know no wind");
  ELASTOGEN_CHECK(scene.dependent.empty(), "explicit steps know no dependent nodes");
  ELASTOGEN_CHECK(scene.mesh.element != Element::kVoxel, "explicit steps take no voxel elements");
  ELASTOGEN_CHECK(scene.colliders.empty() || scene.contact.nodes.cols() == 1,
                  "explicit steps take contact points that are nodes");
}

void ExplicitFem::step(FemState& state) {
  const double dt = scene_.dt, time = double(state.steps) * dt;
  const int64_t nodes = scene_.mesh.rest.rows();
  ELASTOGEN_CHECK(In<double>(state.u).is(nodes, 3) && In<double>(state.v).is(nodes, 3),
                  "u and v of the state must be (", nodes, ", 3)");

  // forces at u; the flow up to u is committed
  gradient_.fill(0);
  if (terms_.elastic) terms_.elastic->add_gradient(state.u, gradient_);
  if (terms_.plastic) terms_.plastic->body().add_gradient_and_commit(state.u, gradient_);
  const bool touches = terms_.contact.exists();
  if (touches) {
    terms_.contact.stand_without_friction(time - dt, dt);
    terms_.contact.add_gradient(state.u, gradient_);
    pushes_ = terms_.contact.pushes(state.u);
  }

  const Array<double> force = applied_force(scene_, time, 1);
  const Array<double>& mass = terms_.potential.mass().nodal();
  for (int64_t k = 0; k < state.v.size(); ++k)
    state.v.data()[k] += dt * ((force.data()[k] - gradient_.data()[k]) / mass(k / 3) +
                               scene_.gravity[size_t(k % 3)]);
  if (touches) terms_.contact.rub(state.u, mass, dt, state.v);

  // fixed components follow their prescribed motion
  ++state.steps;
  state.time = double(state.steps) * dt;
  const Array<double> given = with_motion(scene_, state.time, state.u);
  for (int64_t k = 0; k < state.v.size(); ++k) {
    if (terms_.potential.is_fixed(k))
      state.v.data()[k] = (given.data()[k] - state.u.data()[k]) / dt;
    state.u.data()[k] += dt * state.v.data()[k];
  }
}

}  // namespace elastogen::fem
