// SPDX-License-Identifier: Apache-2.0
#include "scene/stepper.hpp"

#include "core/error.hpp"
#include "scene/fem_stepper.hpp"
#include "scene/network_stepper.hpp"
#include "scene/particle_stepper.hpp"
#include "scene/static_stepper.hpp"

namespace elastogen {

std::unique_ptr<Stepper> make_stepper(const Setup& setup, const RunDescription& run,
                                      const StepperHooks& hooks, std::vector<std::string>& notes) {
  const bool stages = has_stages(setup.scene.scheme), statics = run.fem && run.fem->statics;
  ELASTOGEN_CHECK(
      !stages || (!setup.particles && !statics),
      "particles and statics have no time schemes sdirk2 and auto: ", "--time-scheme euler");
  ELASTOGEN_CHECK(!stages || setup.yields.empty(),
                  "a material that yields has no time schemes sdirk2 and auto, as their rejected ",
                  "steps cannot take its flow back: --time-scheme euler");
  if (setup.particles) return make_particle_stepper(setup, run, hooks.stop);
  ELASTOGEN_CHECK(method_of(run) != Method::kMpm, "tetrahedra of a file are no particles: set fem");
  if (statics) return make_static_stepper(setup, run);
  if (run.fem) return make_fem_stepper(setup, run, hooks.stop);
  ELASTOGEN_CHECK(setup.yields.empty(), "the network steps no material that yields: set fem");
  SolverOptions solver = run.solver;
  solver.learned = scene_nets(setup.scene, run, hooks.make_net, notes);
  solver.interrupted = hooks.stop;
  return make_network_stepper(setup.scene, solver);
}

}  // namespace elastogen
