// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/explicit_mpm.hpp"

#include "core/error.hpp"
#include "mpm_fem/mpm/end_step.hpp"
#include "mpm_fem/mpm/g2p.hpp"

#include <algorithm>

namespace elastogen::mpm {
namespace {

Mat3<Eight> stress_lanes(const Array<double>& stress, const CellPack& pack) {
  Eight s[6];
  for (int k = 0; k < 6; ++k) s[k] = row_lanes(stress, pack, k);
  return {s[0], s[3], s[5], s[3], s[1], s[4], s[5], s[4], s[2]};
}

}  // namespace

template <int d>
ExplicitMpm<d>::ExplicitMpm(const MpmScene& scene, int substeps)
    : scene_(scene), substeps_(substeps), grid_(scene.h) {
  check_scene(scene);
  ELASTOGEN_CHECK(substeps >= 1, "substeps must be at least 1, got ", substeps);
  for (const Solid& solid : scene.solids) laws_.push_back(point_law<d>(solid));
}

template <int d>
double ExplicitMpm<d>::stable_step() const {
  double fastest = 0;
  for (const Solid& solid : scene_.solids) fastest = std::max(fastest, wave_speed(solid.elastic));
  return 0.5 * scene_.h / fastest;
}

/// -V tau Finc^-T of a pack [N m].
template <int d>
Mat3<Eight> ExplicitMpm<d>::force_of(int64_t k, const Particles& p) const {
  const CellPack& pack = grid_.packs()[size_t(k)];
  Mat3<Eight> A = stress_lanes(p.stress, pack);
  if (!increment_.empty()) A = times_transposed(A, inverse(increment_[size_t(k)]));
  const Eight volume = counted_lanes(p.volume, pack, 0);
  for (Eight& a : A.m) a *= -volume;
  return A;
}

/// Forces of the particles' stress on the nodes [N] at the start of a step.
template <int d>
void ExplicitMpm<d>::add_forces(const Particles& p, Array<double>& force) {
  add_tiles<d, kFour>(grid_, scratch_, force, [&](int64_t b, double* tile) {
    for_packs<d>(grid_, b, [&](int64_t k, const PackSpline<d>& s) {
      add_nodal_product<d>(grid_, k, s, force_of(k, p), tile);
    });
  });
}

/// Updates strain, stress and history of the particles for the motion of the nodes since the
/// transfer, and finds the forces of that stress.
template <int d>
void ExplicitMpm<d>::strain_particles(const Array<double>& motion, Particles& p,
                                      Array<double>& force) {
  if (increment_.empty()) increment_.assign(grid_.packs().size(), identity<Eight>());
  const auto add = [&](int64_t k, const PackSpline<d>& s, const double* read, double* write) {
    const Mat3<Eight> now = deformed(nodal_gradient<d>(grid_, k, s, read));
    end_pack(k, now, p);
    increment_[size_t(k)] = now;
    add_nodal_product<d>(grid_, k, s, force_of(k, p), write);
  };
  gather_scatter<d>(grid_, motion, scratch_, force, add);
}

/// Ends a substep at a pack.
/// @param now  Finc
template <int d>
void ExplicitMpm<d>::end_pack(int64_t k, const Mat3<Eight>& now, Particles& p) {
  const CellPack& pack = grid_.packs()[size_t(k)];
  for (int begin = 0; begin < pack.count; begin += lane_count<WidePack>)
    end_lanes(k, begin, part<WidePack>(now, begin), p);
}
template <int d>
void ExplicitMpm<d>::end_lanes(int64_t k, int begin, const Mat3<WidePack>& now, Particles& p) {
  const CellPack& pack = grid_.packs()[size_t(k)];
  Mat3<WidePack> F = matrix_lanes<WidePack>(p.F, pack, begin);
  if (!increment_.empty()) F = inverse(part<WidePack>(increment_[size_t(k)], begin)) * F;
  end_step<d>(laws_, pack, begin, now * F, p);
}

/// Adds forces and gravity to the velocities, applies colliders, and moves the nodes.
template <int d>
void ExplicitMpm<d>::move_nodes(double time, double delta, const NodeMotion& start,
                                const Array<double>& force, Array<double>& v, Array<double>& u) {
  for_each(grid_.nodes(), [&](int64_t i) {
    if (start.mass(i) == 0) return;
    for (int a = 0; a < d; ++a)
      v(i, a) += delta * (force(i, a) / start.mass(i) + scene_.gravity[size_t(a)]);
  });
  obstacles_.begin(grid_, scene_.obstacles, time, delta);
  for_each(obstacles_.count(), [&](int64_t c) {
    double* own = v.row(obstacles_.node(c));
    const Vec3 m = obstacles_.allowed(c, {delta * own[0], delta * own[1], delta * own[2]}, nullptr);
    for (size_t a = 0; a < 3; ++a) own[a] = m[a] / delta;
  });
  for_each(u.size(), [&](int64_t i) { u.data()[i] += delta * v.data()[i]; });
}

template <int d>
void ExplicitMpm<d>::step(double time, Particles& p) {
  grid_.update(p.x);
  increment_.clear();
  // the first force goes with the momenta, unless velocities before it are needed
  const double delta = scene_.dt / substeps_;
  const bool apart = looks_back(scene_.transfer);
  const NodeMotion start = particles_to_grid<d>(grid_, p, scratch_, apart ? 0 : delta);
  Array<double> v = start.velocity, u(substeps_ > 1 ? grid_.nodes() : 0, 3);
  Array<double> force(grid_.nodes(), 3);
  if (apart) add_forces(p, force);
  for (int k = 0; k < substeps_; ++k) {
    move_nodes(time + k * delta, delta, start, force, v, u);
    if (k + 1 < substeps_) strain_particles(u, p, force);
  }
  grid_to_particles<d>(
      grid_, u, start.velocity, v, scene_.transfer, scene_.dt, p,
      [&](int64_t k, int begin, const Mat3<WidePack>& G) { end_lanes(k, begin, deformed(G), p); });
}

template class ExplicitMpm<2>;
template class ExplicitMpm<3>;

}  // namespace elastogen::mpm
