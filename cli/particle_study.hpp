// SPDX-License-Identifier: Apache-2.0
// Runs the particles of one scene by several integrators from one start, and measures how alike
// their clouds remain (docs/study.md, particles).

#pragma once

#include "cli/options.hpp"
#include "io/step_log.hpp"
#include "mpm_fem/mpm/compare.hpp"
#include "scene/particle_integrator.hpp"

#include <cmath>

namespace elastogen {

/// Likeness of a cloud without a reference.
inline constexpr mpm::Likeness kUnknown = {NAN, NAN, NAN, NAN};

/// State of a run at the end of a frame, and cost of the steps since the frame before.
struct ParticleFrame {
  double time = 0;                     ///< [s]
  Array<double> x;                     ///< [m], (particles, 3)
  CloudReport cloud;                   ///< box and volume
  double kinetic = 0, elastic = 0;     ///< [J]
  int64_t solves = 0, iterations = 0;  ///< linear solves, and their iterations of GMRES
  int64_t not_converged = 0;           ///< steps that did not converge
  double residual = 0;                 ///< largest of the steps
  mpm::Likeness to_sub = kUnknown, to_explicit = kUnknown;  ///< to the references of the study
};

struct ParticleRun {
  std::string name;  ///< implicit, explicit or explicit-sub, with its dt
  ParticleOptions options;
  int64_t steps = 0, solves = 0, iterations = 0, factored = 0, not_converged = 0;
  double worst_residual = 0;
  double step_seconds = 0;            ///< of all threads together, median
  bool broke_off = false;             ///< a step had no finite result; frames end before it
  std::vector<ParticleFrame> frames;  ///< the first is the start
};

struct ParticleStudyResult {
  std::string scene, command, commit, date, cpu;
  int threads = 0;  ///< 0: all
  int dimension = 3;
  int64_t particles = 0;
  double h = 0;                                   ///< [m]
  double crossing = 0;                            ///< h/c [s]
  std::string transfer;                           ///< transfer of all runs
  std::string sub_reference, explicit_reference;  ///< names of runs
  std::vector<ParticleRun> runs;

  const ParticleRun* find(const std::string& name) const;
};

/// Runs implicit steps of particles.dt; explicit substeps on unchanged nodes between the same
/// transfers (the reference, and with four times as many for the noise floor); and explicit steps
/// with a transfer after each. After a signal it returns the results so far.
/// @throws Error as set_up and make_particle_integrator
ParticleStudyResult particle_study(const StudyTask& task);

/// particles.json and particles.csv in a folder (docs/study.md).
void write_particle_study(const std::string& folder, const ParticleStudyResult& result);

/// Prints a line for each run.
void print_particle_study(const ParticleStudyResult& result);

/// Worst and mean likeness over the frames after the first; NaN without a reference.
struct LikenessRange {
  double worst = 1, mean = 1;
};
LikenessRange range_of(const ParticleRun& run, mpm::Likeness ParticleFrame::*reference,
                       double mpm::Likeness::*which);

}  // namespace elastogen
