// SPDX-License-Identifier: Apache-2.0
// Runs that are kept step by step, and how far they are from each other.

#pragma once

#include "io/study_result.hpp"
#include "scene/stepper.hpp"
#include "voxelize/body.hpp"

namespace elastogen {

/// States of a run: entry 0 is the start, entry n + 1 what step n came to.
struct Trajectory {
  std::vector<State> states;
  std::vector<StepReport> reports;
  bool broke_off = false;  ///< a step had no finite result; states end before it
};

/// Steps from the start for `steps` steps.
Trajectory free_run(Stepper& stepper, const StartMotion& motion, int64_t steps);

/// Points that stand for the mass of a scene: the centroid of each voxel's fill, which its corners
/// carry with their shape function means, with the mass of the fill.
struct MassPoints {
  Array<double> position;  ///< at rest [m], (points, 3)
  Array<double> mass;      ///< [kg], (points, 1)
};
MassPoints mass_points(const Scene& scene);

/// Displacements [m] of points that a scene's grid carries, (points, 3).
Array<double> displacements(const Scene& scene, In<double> points, const State& state);

/// sqrt(sum_p m_p |a_p - b_p|^2 / sum_p m_p) of rows, [m].
double weighted_rms(In<double> a, In<double> b, In<double> mass);

/// Displacement errors on one grid, node by node with their masses: the rms distance of positions
/// at the end of each step over the largest rms displacement that the reference has in the run.
/// step_errors starts each step at the reference's state.
/// @return inf from where the run broke off.
ErrorSeries step_errors(Stepper& stepper, const Scene& scene, const Trajectory& reference);
ErrorSeries free_run_errors(const Scene& scene, const Trajectory& run, const Trajectory& reference);

/// The same between two grids of one asset, at the mass points of `scene`.
ErrorSeries errors_between(const Scene& scene, const Trajectory& run, const Scene& reference_scene,
                           const Trajectory& reference);

/// Total energies' largest difference over the reference's largest kinetic energy [-].
double energy_drift(const Trajectory& run, const Trajectory& reference);

/// Vertices of a body's surface as a state has them [m], (vertices, 3).
Array<double> surface_at(const Body& body, const Scene& scene, const State& state);

/// Volume of the common part of two shapes of one surface over that of their union, from the fills
/// of voxels of edge h; NaN if one cannot be voxelised.
double shape_iou(const Surface& surface, const Array<double>& a, const Array<double>& b, double h);

/// Where a plane across an axis cuts a surface: segments [m] in the two other axes in their order.
std::vector<Polyline> section(const Surface& surface, const Array<double>& vertices, int axis,
                              double place);

}  // namespace elastogen
