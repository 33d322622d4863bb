// SPDX-License-Identifier: Apache-2.0
// The plots of study.html as HTML figures. Each function returns "" if there is nothing to draw.

#pragma once

#include "io/study_result.hpp"

namespace elastogen {

/// Largest error over the median time of a step, both logarithmic: a plot for each family and
/// measure, a line for each solver, element and reference.
std::string error_time_figures(const std::vector<StudyRun>& runs);

/// Error over the varied quantity, both logarithmic: a plot for each variable, family and measure,
/// with a table of the points and the orders between neighbours.
std::string sweep_figures(const std::vector<StudySweep>& sweeps);

/// Residual of each step over its time, a line a run.
std::string residual_figure(const std::vector<StudyRun>& runs);

/// Total energy over time, a line a run; below it, folded, the parts of the energy, a plot a run.
std::string energy_figures(const std::vector<StudyRun>& runs);

/// Error of each step over its time: a plot for each family and measure, a line a run.
std::string error_series_figures(const std::vector<StudyRun>& runs);

std::string overlay_figures(const std::vector<ShapeOverlay>& overlays);

}  // namespace elastogen
