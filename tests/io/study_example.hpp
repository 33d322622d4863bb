// SPDX-License-Identifier: Apache-2.0
// A study for the tests of its writers, in which no two numbers are the same.

#pragma once

#include "io/study_errors.hpp"

#include <cmath>

namespace elastogen::test {

/// A name that would run, close an attribute or a style, or break a table if it were not escaped.
inline const std::string kHostile =
    "<script>alert(1)</script>\"'><img src=x onerror=a>&amp;</style>]]>\n, \x01\xff";

inline StudyErrors example_errors(const std::string& reference, double scale) {
  StudyErrors errors;
  errors.reference = reference;
  errors.step = {{1.25 * scale, 1.5 * scale}, 1.5 * scale};
  errors.free_run = {{2.25 * scale, 2.5 * scale}, 2.5 * scale};
  errors.iou = 1 - scale;
  errors.energy_drift = 3.25 * scale;
  return errors;
}

/// A run of two steps of 0.5 s.
inline StudyRun example_run(const std::string& name, const std::string& solver, double ms,
                            double scale) {
  StudyRun run;
  run.name = name;
  run.solver = solver;
  run.element = "voxel";
  // sizes
  run.h = 0.03125;
  run.dt = 0.5;
  run.tolerance = scale;
  run.steps = 2;
  run.voxels = 64;
  run.elements = 65;
  run.dofs = 300;
  // cost
  run.step_ms = {0.875 * ms, ms, 1.125 * ms};
  run.state_bytes = 6000;
  run.state_copies_per_second = 12500;
  run.outer = 7;
  run.inner = 18;
  // quality
  run.converged_share = 0.5;
  run.worst_residual = 2 * scale;
  run.min_j = 0.8125;
  run.residual = {scale / 2, 2 * scale};
  run.energy = {{1, 2}, {3, 4}, {5, 6}, {7, 8}, {9, 10}, {25, 30}};
  // errors
  run.solver_error = example_errors("newton 1e-12", scale);
  run.discretisation_error = example_errors("tet10 fine", 16 * scale);
  run.discretisation_error->reference_change = 0.0625;
  return run;
}

/// A run on tetrahedra with fixed loops and no errors.
inline StudyRun example_reference() {
  StudyRun run = example_run("tet10 fine", "fem", 4096, 6.103515625e-05);
  run.element = "tet10";
  run.voxels = 0;
  run.tolerance.reset();
  run.loops = LoopBudget{10, 20, 54};
  run.solver_error.reset();
  run.discretisation_error.reset();
  return run;
}

/// Four runs: quasi at two tolerances, newton, and the reference.
inline StudyResult example_study() {
  StudyResult study;
  study.header = {"beam",
                  "h = 0.03125\n",
                  "elastogen study beam.toml",
                  "abc123",
                  "2026-11-22T10:00:00Z",
                  2,
                  5,
                  {"AMD EPYC", 4, int64_t{24} << 30, 23.75e9}};
  // runs
  study.runs = {example_run("quasi 1e-2", "quasi", 8, 0.0078125),
                example_run("quasi 1e-3", "quasi", 16, 0.00048828125),
                example_run("newton 1e-3", "newton", 24, 0.000244140625), example_reference()};
  study.time_to_error = times_to_error(study.runs);
  // a sweep, an overlay and two known numbers
  study.sweeps = {{"quasi, voxel",
                   "h",
                   "m",
                   ErrorFamily::kDiscretisation,
                   ErrorMeasure::kFreeRun,
                   {0.125, 0.0625, 0.03125},
                   {0.25, 0.0625, 0.015625},
                   2}};
  study.overlays = {{"last frame",
                     1,
                     "x",
                     "y",
                     {{"quasi 1e-3", {{{0, 0}, {1, 0}, {1, 0.25}, {0, 0.25}, {0, 0}}}},
                      {"tet10 fine", {{{0, 0.125}, {1, 0.375}}, {{0.75, 0.5}}}}}}};
  study.figures = {{"first frequency", 5.0625, 5.078125, 0.05078125, "Hz", true},
                   {"tip deflection", 0.25, 0.3125, 0.0078125, "m", false}};
  return study;
}

}  // namespace elastogen::test
