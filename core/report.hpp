// SPDX-License-Identifier: Apache-2.0
// The report of a step. Not converging is a value of it: a draft, with its residual.

#pragma once

#include "core/ledger.hpp"
#include "core/mesh_error.hpp"
#include "core/scene.hpp"

#include <optional>
#include <string>

namespace elastogen {

/// Energies at the end of a step [J].
struct EnergyParts {
  double kinetic = 0, elastic = 0, hourglass = 0, gravity = 0, contact = 0;
  double plastic = 0;  ///< work of plastic flow since the start, of metals with that of hardening
};

struct StepReport {
  int64_t step = 0;   ///< counted from 1
  double time = 0;    ///< at the end of the step [s]
  double length = 0;  ///< of the step [s]
  TimeScheme scheme = TimeScheme::kEuler;
  bool completes = true;     ///< it ends an interval dt of the scene; shorter steps make it up
  int solves = 1;            ///< minimisations of Phi: stages, those of rejected steps included
  bool guarded = false;      ///< contact would have brought energy, which velocities have lost
  int rejected = 0;          ///< steps that were tried before and had too large a time error
  double time_error = 0;     ///< estimate of what the step adds to the time error [m]; 0: none made
  double time_ratio = 0;     ///< that over its tolerance, of the piece where it is largest
  bool converged = false;    ///< residual <= tolerance
  double tolerance = 0;      ///< of the residual, in this step; 0: that of the run
  double residual = 0;       ///< |grad Phi| / |M g_ref| in float64 on the state that is written
  int outer = 0;             ///< quasi: L-BFGS iterations; newton: Newton steps
  int inner = 0;             ///< quasi: evaluations of the potential; newton: PCG iterations
  bool yields = false;       ///< a material can yield: energy.plastic and fallbacks are filled
  int fallbacks = 0;         ///< frozen steps after steps that failed, and parts that were undone
  bool float64 = false;      ///< the iteration ran in float64 (docs/physics.md, precision)
  bool finite = true;        ///< false: the step was refused and the state is the one before
  std::string refusal;       ///< why, where there is more to say; or why it is a draft
  bool interrupted = false;  ///< the step was given up on request; the state is the one before
  double min_j = 1;          ///< smallest det F of a voxel
  double min_corner_j = 1;   ///< smallest det F at a corner of a full voxel
  EnergyParts energy;
  double damped = 0;                ///< energy that damping took in the step [J]
  StepLedger ledger;                ///< of steps of stages
  int64_t outside_fit = 0;          ///< voxels whose net handed over to its law, in the end state
  double active_share = 1;          ///< share of the voxels that was stepped
  double deepest_overlap = 0;       ///< of a surface point with a collider [voxel edges]
  double ms = 0;                    ///< wall time
  std::vector<Reaction> reactions;  ///< of each holder of the scene, at the end of the step
  std::optional<MeshError> mesh_error = {};  ///< at the end of a frame, where that gets one
};

}  // namespace elastogen
