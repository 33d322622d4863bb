// SPDX-License-Identifier: Apache-2.0
#include "cli/study_compare.hpp"

#include "core/error.hpp"
#include "voxelize/embedding.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace elastogen {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

/// The first rows of an array.
Span<const double> first_rows(const Array<double>& array, int64_t rows) {
  return {array.data(), rows, array.cols()};
}

/// Largest rms displacement of the reference at the end of a step.
double largest_displacement(const Scene& scene, const Trajectory& reference) {
  double largest = 0;
  for (const State& state : reference.states)
    largest = std::max(largest, weighted_rms(first_rows(state.x, scene.grid.node_count()),
                                             scene.grid.rest, scene.mass));
  return largest;
}

/// Rms distance of two states over a length.
double displacement_error(const Scene& scene, const State& state, const State& reference,
                          double size) {
  const int64_t nodes = scene.grid.node_count();
  const double error =
      weighted_rms(first_rows(state.x, nodes), first_rows(reference.x, nodes), scene.mass);
  if (!std::isfinite(error)) return kInfinity;
  return error == 0 ? 0 : error / size;
}

void add(double error, ErrorSeries& series) {
  series.steps.push_back(error);
  series.max = std::max(series.max, error);
}

double total(const EnergyParts& e) {
  return e.kinetic + e.elastic + e.hourglass + e.gravity + e.contact;
}

using VoxelKey = std::array<int64_t, 3>;

/// Fill of each voxel, by its place in a lattice with planes through 0.
std::map<VoxelKey, double> fills(const Surface& surface, const Array<double>& vertices, double h) {
  Surface moved = surface;
  moved.vertices = vertices;
  moved.box = {};
  for (int64_t k = 0; k < moved.triangles.size(); ++k) {
    const double* x = vertices.row(moved.triangles.data()[k]);
    moved.box.add({x[0], x[1], x[2]});
  }
  VoxelizeOptions options;
  options.h = h;
  for (std::optional<double>& plane : options.align) plane = 0;
  const VoxelGrid grid = voxelize(moved, options).grid;
  std::map<VoxelKey, double> result;
  for (int64_t v = 0; v < grid.voxel_count(); ++v) {
    VoxelKey key;
    for (int d = 0; d < 3; ++d) key[size_t(d)] = std::llround(grid.rest(grid.corners(v, 0), d) / h);
    result[key] = grid.fill(v);
  }
  return result;
}

}  // namespace

Trajectory free_run(Stepper& stepper, const StartMotion& motion, int64_t steps) {
  Trajectory run;
  stepper.begin(motion);
  run.states.push_back(stepper.state());
  for (int64_t n = 0; n < steps; ++n) {
    const StepReport report = stepper.advance();
    run.broke_off = !report.finite || report.interrupted;
    if (run.broke_off) break;
    run.reports.push_back(report);
    run.states.push_back(stepper.state());
  }
  return run;
}

MassPoints mass_points(const Scene& scene) {
  const VoxelGrid& grid = scene.grid;
  const int64_t count = grid.voxel_count();
  MassPoints points{Array<double>(count, 3), Array<double>(count)};
  for (int64_t v = 0; v < count; ++v) {
    const double density = scene.materials[size_t(scene.material(v))].density;
    points.mass(v) = density * grid.fill(v) * grid.h * grid.h * grid.h;
    for (int c = 0; c < 8; ++c)
      for (int d = 0; d < 3; ++d)
        points.position(v, d) += grid.shape_mean(v, c) * grid.rest(grid.corners(v, c), d);
  }
  return points;
}

Array<double> displacements(const Scene& scene, In<double> points, const State& state) {
  Array<double> result(points.rows, 3);
  deform_asset(scene.grid, embed(scene.grid, points), first_rows(state.x, scene.grid.node_count()),
               result);
  return result;
}

double weighted_rms(In<double> a, In<double> b, In<double> mass) {
  ELASTOGEN_CHECK(a.rows == b.rows && a.rows == mass.rows && a.cols == b.cols,
                  "rows of unlike arrays cannot be compared");
  double sum = 0, total = 0;
  for (int64_t p = 0; p < a.rows; ++p) {
    for (int d = 0; d < a.cols; ++d) sum += mass(p) * (a(p, d) - b(p, d)) * (a(p, d) - b(p, d));
    total += mass(p);
  }
  return std::sqrt(sum / total);
}

ErrorSeries step_errors(Stepper& stepper, const Scene& scene, const Trajectory& reference) {
  const double size = largest_displacement(scene, reference);
  ErrorSeries series;
  for (size_t n = 0; n + 1 < reference.states.size(); ++n) {
    stepper.begin_at(reference.states[n]);
    const bool finite = stepper.advance().finite;
    add(finite ? displacement_error(scene, stepper.state(), reference.states[n + 1], size)
               : kInfinity,
        series);
  }
  return series;
}

ErrorSeries free_run_errors(const Scene& scene, const Trajectory& run,
                            const Trajectory& reference) {
  const double size = largest_displacement(scene, reference);
  ErrorSeries series;
  for (size_t n = 1; n < reference.states.size(); ++n)
    add(n < run.states.size() ? displacement_error(scene, run.states[n], reference.states[n], size)
                              : kInfinity,
        series);
  return series;
}

ErrorSeries errors_between(const Scene& scene, const Trajectory& run, const Scene& reference_scene,
                           const Trajectory& reference) {
  const MassPoints points = mass_points(scene);
  const Array<double> rest(points.position.rows(), 3);
  std::vector<Array<double>> truth;
  double size = 0;
  for (const State& state : reference.states) {
    truth.push_back(displacements(reference_scene, points.position, state));
    size = std::max(size, weighted_rms(truth.back(), rest, points.mass));
  }
  ErrorSeries series;
  for (size_t n = 1; n < truth.size(); ++n)
    add(n < run.states.size() ? weighted_rms(displacements(scene, points.position, run.states[n]),
                                             truth[n], points.mass) /
                                    size
                              : kInfinity,
        series);
  return series;
}

double energy_drift(const Trajectory& run, const Trajectory& reference) {
  double difference = 0, kinetic = 0;
  for (size_t n = 0; n < std::min(run.reports.size(), reference.reports.size()); ++n) {
    const EnergyParts &a = run.reports[n].energy, &b = reference.reports[n].energy;
    difference = std::max(difference, std::abs(total(a) - total(b)));
    kinetic = std::max(kinetic, b.kinetic);
  }
  return kinetic > 0 ? difference / kinetic : 0;
}

Array<double> surface_at(const Body& body, const Scene& scene, const State& state) {
  Array<double> vertices = displacements(scene, body.surface.vertices, state);
  for (int64_t k = 0; k < vertices.size(); ++k)
    vertices.data()[k] += body.surface.vertices.data()[k];
  return vertices;
}

double shape_iou(const Surface& surface, const Array<double>& a, const Array<double>& b, double h) {
  try {
    const std::map<VoxelKey, double> left = fills(surface, a, h), right = fills(surface, b, h);
    double common = 0, whole = 0;
    for (const auto& [key, fill] : left) {
      const auto other = right.find(key);
      const double there = other == right.end() ? 0 : other->second;
      common += std::min(fill, there);
      whole += std::max(fill, there);
    }
    for (const auto& [key, fill] : right)
      if (!left.contains(key)) whole += fill;
    return common / whole;
  } catch (const Error&) {
    return std::numeric_limits<double>::quiet_NaN();
  }
}

std::vector<Polyline> section(const Surface& surface, const Array<double>& vertices, int axis,
                              double place) {
  const int first = axis == 0 ? 1 : 0, second = axis == 2 ? 1 : 2;
  std::vector<Polyline> lines;
  for (int64_t t = 0; t < surface.triangles.rows(); ++t) {
    Polyline cut;
    for (int k = 0; k < 3; ++k) {
      const double* a = vertices.row(surface.triangles(t, k));
      const double* b = vertices.row(surface.triangles(t, (k + 1) % 3));
      const double da = a[axis] - place, db = b[axis] - place;
      if ((da < 0) == (db < 0)) continue;
      const double s = da / (da - db);
      cut.push_back(
          {a[first] + s * (b[first] - a[first]), a[second] + s * (b[second] - a[second])});
    }
    if (cut.size() == 2) lines.push_back(std::move(cut));
  }
  return lines;
}

}  // namespace elastogen
