// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/fem_state.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"

#include <cmath>

namespace elastogen::fem {
namespace {

void check_state_array(const Array<double>& array, int64_t nodes, const char* name) {
  ELASTOGEN_CHECK(array.rows() == nodes && array.cols() == 3, "state.", name,
                  " must be (nodes, 3) with ", nodes, " nodes, got (", array.rows(), ", ",
                  array.cols(), ")");
}

}  // namespace

FemState rest_state(const FemScene& scene) {
  FemState state;
  state.u = Array<double>(scene.mesh.rest.rows(), 3);
  state.v = state.u;
  return state;
}

void check_state(const FemState& state, int64_t nodes) {
  check_state_array(state.u, nodes, "u");
  check_state_array(state.v, nodes, "v");
  ELASTOGEN_CHECK(state.u_before.empty() == state.v_before.empty(),
                  "state.u_before and state.v_before must both be given or both be empty");
  if (!state.a.empty()) check_state_array(state.a, nodes, "a");
  if (state.u_before.empty()) return;
  check_state_array(state.u_before, nodes, "u_before");
  check_state_array(state.v_before, nodes, "v_before");
}

double reference_force(const FemScene& scene, const Array<double>& nodal_mass) {
  double sum = 0;
  std::vector<uint8_t> follows(size_t(nodal_mass.rows()));
  for (int64_t i = 0; i < scene.dependent.count(); ++i)
    follows[size_t(scene.dependent.node(i))] = 1;
  for (int64_t n = 0; n < nodal_mass.rows(); ++n) {
    if (follows[size_t(n)]) continue;
    bool free = scene.fixed.empty();
    for (int i = 0; i < 3 && !free; ++i) free = !scene.fixed(n, i);
    if (free) sum += nodal_mass(n) * nodal_mass(n);
  }
  return kReferenceGravity * std::sqrt(sum);
}

Array<double> applied_force(const FemScene& scene, double time, double traction_share) {
  const int64_t nodes = scene.mesh.rest.rows();
  Array<double> force(nodes, 3);
  if (scene.force) scene.force(time, force);
  if (scene.traction.empty()) return force;
  ELASTOGEN_CHECK(scene.traction.rows() == nodes && scene.traction.cols() == 3,
                  "traction must be (nodes, 3) with ", nodes, " nodes, got (",
                  scene.traction.rows(), ", ", scene.traction.cols(), ")");
  for (int64_t k = 0; k < force.size(); ++k)
    force.data()[k] += traction_share * scene.traction.data()[k];
  return force;
}

Array<double> with_motion(const FemScene& scene, double time, const Array<double>& u) {
  Array<double> result = u;
  if (scene.fixed.empty()) return result;
  Array<double> given(u.rows(), 3);
  if (scene.motion) scene.motion(time, given);
  for (int64_t k = 0; k < u.size(); ++k)
    if (scene.fixed.data()[k]) result.data()[k] = given.data()[k];
  return result;
}

Array<double> dependent_offset(const FemScene& scene, double time) {
  Array<double> offset(scene.dependent.count(), 3);
  if (scene.dependent_motion) scene.dependent_motion(time, offset);
  return offset;
}

}  // namespace elastogen::fem
