// SPDX-License-Identifier: Apache-2.0
// Runs kept step by step, and their distance from each other.

#pragma once

#include "io/study_result.hpp"
#include "scene/stepper.hpp"
#include "voxelize/body.hpp"

namespace elastogen {

/// States of a run: entry 0 is the start, entry n + 1 the state after step n.
struct Trajectory {
  std::vector<State> states;
  std::vector<StepReport> reports;
  bool broke_off = false;  ///< a step had no finite result; states end before it
};

/// Steps from the start, `steps` times.
Trajectory free_run(Stepper& stepper, const StartMotion& motion, int64_t steps);

/// Points that represent the mass of a scene: the centroid of each voxel's fill, with the mass of
/// the fill. The corners carry it by the means of their shape functions.
struct MassPoints {
  Array<double> position;  ///< at rest [m], (points, 3)
  Array<double> mass;      ///< [kg], (points, 1)
};
MassPoints mass_points(const Scene& scene);

/// Displacements of points that a scene's grid carries [m], (points, 3).
Array<double> displacements(const Scene& scene, In<double> points, const State& state);

/// sqrt(sum_p m_p |a_p - b_p|^2 / sum_p m_p) of rows, [m].
double weighted_rms(In<double> a, In<double> b, In<double> mass);

/// Displacement errors on one grid, node by node with nodal masses: the rms distance of positions
/// at the end of each step, over the largest rms displacement of the reference during the run.
/// step_errors starts each step from the reference's state.
/// @return inf from where the run broke off.
ErrorSeries step_errors(Stepper& stepper, const Scene& scene, const Trajectory& reference);
ErrorSeries free_run_errors(const Scene& scene, const Trajectory& run, const Trajectory& reference);

/// Displacement errors between two grids of one asset, at the mass points of `scene`.
ErrorSeries errors_between(const Scene& scene, const Trajectory& run, const Scene& reference_scene,
                           const Trajectory& reference);

/// Largest difference of total energies over the reference's largest kinetic energy [-].
double energy_drift(const Trajectory& run, const Trajectory& reference);

/// Vertices of a body's surface moved by a state [m], (vertices, 3).
Array<double> surface_at(const Body& body, const Scene& scene, const State& state);

/// Volume of the common part of two shapes of one surface over that of their union, from the fills
/// of voxels of edge h; NaN if one cannot be voxelised.
double shape_iou(const Surface& surface, const Array<double>& a, const Array<double>& b, double h);

/// Section of a surface with a plane across an axis: segments [m] in the other two axes in order.
std::vector<Polyline> section(const Surface& surface, const Array<double>& vertices, int axis,
                              double place);

}  // namespace elastogen
