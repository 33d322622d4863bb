// SPDX-License-Identifier: Apache-2.0
#include "core/scene.hpp"

#include "core/constants.hpp"
#include "core/error.hpp"
#include "core/held_nodes.hpp"
#include "core/parallel.hpp"
#include "core/reduce.hpp"
#include "core/state.hpp"
#include "core/vec3.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace elastogen {
namespace {

/// Whether fits(i) for all i of [0, n).
template <class Fits>
bool all_fit(int64_t n, const Fits& fits) {
  return ordered_sum(n, [&](int64_t begin, int64_t end) {
           double misfits = 0;
           for (int64_t i = begin; i < end; ++i) misfits += !fits(i);
           return misfits;
         }) == 0;
}

/// @throws Error naming the first entry that is not in [lower, upper] (NaN is not).
template <class T>
void check_range(const Array<T>& array, double lower, double upper, const char* name) {
  const T* values = array.data();
  const auto fits = [=](int64_t k) {
    return double(values[k]) >= lower && double(values[k]) <= upper;
  };
  if (all_fit(array.size(), fits)) return;
  for (int64_t k = 0; k < array.size(); ++k) {
    const auto value = double(array.data()[k]);
    ELASTOGEN_CHECK(value >= lower && value <= upper, name, '(', k / array.cols(), ", ",
                    k % array.cols(), ") must lie in [", lower, ", ", upper, "], got ", value);
  }
}

constexpr double kLargest = std::numeric_limits<double>::max();

void check_grid_numbers(const VoxelGrid& grid) {
  const auto voxels = double(grid.voxel_count()), nodes = double(grid.node_count());
  check_range(grid.corners, 0, nodes - 1, "corners");
  check_range(grid.voxels, -1, voxels - 1, "voxels");
  check_range(grid.rest, -kLargest, kLargest, "rest");
  check_range(grid.fill, std::numeric_limits<double>::min(), kLargest, "fill");
  check_range(grid.shape_mean, -kLargest, kLargest, "shape_mean");
  ELASTOGEN_CHECK(std::isfinite(grid.volume), "the volume must be finite, got ", grid.volume);
}

void check_surface(const SurfacePoints& s, int64_t voxels) {
  const int64_t points = s.voxel.rows();
  ELASTOGEN_CHECK(
      s.weights.rows() == points && s.area.rows() == points && s.position.rows() == points,
      "the surface points' arrays differ in length");
  check_range(s.voxel, 0, double(voxels - 1), "surface.voxel");
  check_range(s.weights, -kLargest, kLargest, "surface.weights");
  check_range(s.area, 0, kLargest, "surface.area");
  check_range(s.position, -kLargest, kLargest, "surface.position");
}

void check_scene(const Scene& scene) {
  const VoxelGrid& grid = scene.grid;
  const int64_t voxels = grid.voxel_count(), nodes = grid.node_count();
  const auto is = [](const auto& array, int64_t rows, int cols) {
    return array.rows() == rows && array.cols() == cols;
  };
  // the grid
  ELASTOGEN_CHECK(voxels > 0, "the scene has no voxels");
  ELASTOGEN_CHECK(grid.h > 0 && std::isfinite(grid.h), "h must be positive, got ", grid.h);
  ELASTOGEN_CHECK(is(grid.fill, voxels, 1) && is(grid.shape_mean, voxels, 8) &&
                      is(grid.corners, voxels, 8) && is(grid.voxels, nodes, 8),
                  "the tables of the grid do not fit its ", voxels, " voxels and ", nodes,
                  " nodes");
  check_grid_numbers(grid);
  check_surface(scene.surface, voxels);
  // materials, what is held, what acts
  ELASTOGEN_CHECK(is(scene.material, voxels, 1), "material must be (voxels, 1)");
  ELASTOGEN_CHECK(is(scene.pinned, nodes, 1), "pinned must be (nodes, 1)");
  ELASTOGEN_CHECK(!scene.materials.empty(), "the scene has no material");
  for (const Material& m : scene.materials) check_material(m);
  check_range(scene.material, 0, double(scene.materials.size() - 1), "material");
  ELASTOGEN_CHECK(scene.dt > 0 && std::isfinite(scene.dt), "dt must be positive, got ", scene.dt);
  ELASTOGEN_CHECK(finite(scene.gravity), "gravity must be finite");
  for (const Collider& collider : scene.colliders) check_collider(collider);
  for (const Holder& holder : scene.holders) check_path(holder.path);
  ELASTOGEN_CHECK(scene.holder.empty() || is(scene.holder, nodes, 1), "holder must be (nodes, 1)");
  check_range(scene.holder, -1, double(scene.holders.size()) - 1, "holder");
  ELASTOGEN_CHECK(scene.fixed.empty() || (is(scene.fixed, nodes, 3) && !scene.holder.empty()),
                  "fixed must be (nodes, 3), and comes with holder");
  check_range(scene.fixed, -1, double(scene.holders.size()) - 1, "fixed");
  ELASTOGEN_CHECK(scene.load.empty() || is(scene.load, nodes, 3), "load must be (nodes, 3)");
  check_range(scene.load, -kLargest, kLargest, "load");
  for (const TimedForce& force : scene.forces) {
    ELASTOGEN_CHECK(is(force.share, nodes, 1), "the shares of a force must be (nodes, 1)");
    check_path(force.force);
  }
  check_path(scene.wind.velocity);
  check_range(scene.wind.voxel, 0, double(voxels) - 1, "wind.voxel");
}

/// @throws Error unless the nodes that follow others are those that `pinned` says do.
void check_dependent(const Scene& scene) {
  check_range(scene.pinned, kFreeNode, kDependentNode, "pinned");
  ELASTOGEN_CHECK(scene.dependent.last_node() < scene.pinned.rows(),
                  "dependent nodes are not in the grid");
  int64_t marked = 0, listed = 0;
  for (int64_t n = 0; n < scene.pinned.rows(); ++n) marked += scene.pinned(n) == kDependentNode;
  for (int64_t i = 0; i < scene.dependent.count(); ++i) {
    listed += scene.pinned(scene.dependent.node(i)) == kDependentNode;
    const Span<const int32_t> parents = scene.dependent.parents(i);
    for (int64_t k = 0; k < parents.rows; ++k)
      ELASTOGEN_CHECK(scene.pinned(parents(k)) == kFreeNode, "node ", parents(k),
                      " is a parent node and must be free");
  }
  ELASTOGEN_CHECK(marked == listed && listed == scene.dependent.count(),
                  "the dependent nodes must be those that pinned marks");
  for (int64_t k = 0; k < scene.fixed.size(); ++k)
    ELASTOGEN_CHECK(scene.fixed.data()[k] < 0 || scene.pinned(k / 3) == kFreeNode, "node ", k / 3,
                    " has a fixed component and must be free");
}

void fill_mass(Scene& scene) {
  const VoxelGrid& grid = scene.grid;
  const double scale = volume_scale(grid) * grid.h * grid.h * grid.h;
  scene.mass = Array<double>(grid.node_count());
  for_each(grid.node_count(), [&](int64_t n) {
    double sum = 0;
    for (int c = 0; c < 8; ++c) {
      const int64_t v = grid.voxels(n, c);
      if (v < 0) continue;
      const double rho = scene.materials[size_t(scene.material(v))].density;
      sum += scale * rho * grid.fill(v) * grid.shape_mean(v, c);
    }
    scene.mass(n) = sum;
  });
}

/// Weights of one voxel: which axes have both faces free decides between solid, sheet and strip.
void variance_of_voxel(const VoxelGrid& grid, const Material& m, int64_t v, double weight[4]) {
  constexpr int kAxes[4] = {3, 6, 5, 7};  // axes of the patterns xy, yz, zx, xyz as bits
  const int thin = thin_axes(grid, v), count = (thin & 1) + (thin >> 1 & 1) + (thin >> 2);
  const double E = m.young, nu = m.poisson;
  double c = (m.mu() + E / 2) / 2;
  if (count == 1) c = E / (2 * (1 - nu * nu));
  if (count >= 2) c = E / 2;
  // of the edge that a member across the thin axis fills
  double share = grid.fill(v);
  if (!grid.member.empty() && grid.member(v) > 0) share = grid.member(v);
  if (!grid.sheet.empty() && grid.sheet(v) > 0) share = grid.sheet(v);
  for (int k = 0; k < 4; ++k) weight[k] = kAxes[k] & thin ? c * share * share : c;
}

}  // namespace

double volume_scale(const VoxelGrid& grid) {
  if (grid.volume <= 0) return 1;
  double filled = 0;
  for (int64_t v = 0; v < grid.voxel_count(); ++v) filled += grid.fill(v);
  return grid.volume / (filled * grid.h * grid.h * grid.h);
}

void finish_scene(Scene& scene) {
  check_scene(scene);
  check_dependent(scene);
  fill_mass(scene);
  const double total = ordered_sum(scene.mass.rows(), [&](int64_t begin, int64_t end) {
    return std::accumulate(scene.mass.data() + begin, scene.mass.data() + end, 0.0);
  });
  ELASTOGEN_CHECK(std::isnormal(total), "the mass must be a normal number, got ", total,
                  " kg: h = ", scene.grid.h, " m or the density is out of range");
  const int64_t voxels = scene.grid.voxel_count();
  scene.variance = Array<double>(voxels, 4);
  if (scene.hourglass == Hourglass::kOff) return;
  for_each(voxels, [&](int64_t v) {
    variance_of_voxel(scene.grid, scene.materials[size_t(scene.material(v))], v,
                      scene.variance.row(v));
  });
}

namespace {

/// @throws Error naming the first number of a state array that is not finite.
void check_state_array(const Array<double>& array, int64_t nodes, const char* name) {
  ELASTOGEN_CHECK(array.rows() == nodes && array.cols() == 3, name, " must be (nodes, 3), got (",
                  array.rows(), ", ", array.cols(), ")");
  if (all_finite(array.data(), array.size())) return;
  for (int64_t k = 0; k < array.size(); ++k)
    ELASTOGEN_CHECK(std::isfinite(array.data()[k]), name, '(', k / 3, ", ", k % 3,
                    ") is not finite: ", array.data()[k]);
}

}  // namespace

void check_state(const State& state, int64_t nodes) {
  check_state_array(state.x, nodes, "state.x");
  check_state_array(state.v, nodes, "state.v");
  ELASTOGEN_CHECK(state.x_before.empty() == state.v_before.empty(),
                  "state.x_before and state.v_before must both be given or both be empty");
  if (state.x_before.empty()) return;
  check_state_array(state.x_before, nodes, "state.x_before");
  check_state_array(state.v_before, nodes, "state.v_before");
}

namespace {

/// Centre of mass [m].
Vec3 centre_of(const Scene& scene) {
  double mass = 0;
  Vec3 centre = {};
  for (int64_t n = 0; n < scene.mass.rows(); ++n) {
    mass += scene.mass(n);
    for (size_t d = 0; d < 3; ++d) centre[d] += scene.mass(n) * scene.grid.rest(n, int(d));
  }
  return {centre[0] / mass, centre[1] / mass, centre[2] / mass};
}

}  // namespace

State initial_state(const Scene& scene, const StartMotion& motion) {
  const Array<double>& X = scene.grid.rest;
  const int64_t nodes = X.rows();
  ELASTOGEN_CHECK(scene.mass.rows() == nodes, "initial_state needs a finished scene");
  const double* w = motion.spin;
  const bool spins = w[0] != 0 || w[1] != 0 || w[2] != 0;
  const Vec3 centre = spins ? centre_of(scene) : Vec3{};
  State state;
  state.x = Array<double>(nodes, 3);
  state.v = Array<double>(nodes, 3);
  for_each(nodes, [&](int64_t n) {
    std::copy_n(X.row(n), 3, state.x.row(n));
    if (scene.pinned(n)) return;
    for (int d = 0; d < 3; ++d) {
      const int e = (d + 1) % 3, f = (d + 2) % 3;
      state.v(n, d) = motion.velocity[d];
      if (spins)
        state.v(n, d) = motion.velocity[d] + w[e] * (X(n, f) - centre[size_t(f)]) -
                        w[f] * (X(n, e) - centre[size_t(e)]);
    }
  });
  // what moves stands at the start of its path
  HeldNodes held(scene);
  held.fill(state.v.data());
  if (!held.move()) return state;
  Array<double> u(nodes, 3);
  held.place(u.data());
  held.add_start_rates(1e-3 * scene.dt, state.v.data());
  for (int64_t k = 0; k < u.size(); ++k) state.x.data()[k] += u.data()[k];
  return state;
}

double rounding_floor(const Scene& scene, double epsilon) {
  double stiffest = 0;  // 3 K / rho
  for (const Material& m : scene.materials)
    stiffest = std::max(stiffest, (2 * m.mu() + 3 * m.lambda()) / m.density);
  return 1.5 * epsilon * stiffest / (kReferenceGravity * scene.grid.h);
}

}  // namespace elastogen
