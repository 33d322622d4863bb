// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/explicit_mpm.hpp"

#include "core/error.hpp"
#include "mpm_fem/mpm/g2p.hpp"
#include "mpm_fem/mpm/pack_laws.hpp"

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

template <int d>
void ExplicitMpm<d>::begin_packs(const Particles& p) {
  increment_.assign(grid_.packs().size(), identity<Eight>());
  volume_.resize(grid_.packs().size());
  for_each(int64_t(volume_.size()), [&](int64_t k) {
    volume_[size_t(k)] = counted_lanes(p.volume, grid_.packs()[size_t(k)], 0);
  });
}

/// Forces of the particles' stress on the nodes [N].
template <int d>
void ExplicitMpm<d>::add_forces(const Particles& p, Array<double>& force) {
  add_tiles<d, kFour>(grid_, scratch_, force, [&](int64_t b, double* tile) {
    for_packs<d>(grid_, b, [&](int64_t k, const PackSpline<d>& s) {
      Mat3<Eight> A = times_transposed(stress_lanes(p.stress, grid_.packs()[size_t(k)]),
                                       inverse(increment_[size_t(k)]));
      for (Eight& a : A.m) a *= -volume_[size_t(k)];
      add_nodal_product<d>(grid_, k, s, A, tile);
    });
  });
}

/// Strain, stress and history of the particles when the nodes have moved so far since the transfer.
template <int d>
void ExplicitMpm<d>::strain_particles(const Array<double>& motion, Particles& p) {
  gather<d>(grid_, motion, [&](int64_t k, const PackSpline<d>& s, const double* tile) {
    const CellPack& pack = grid_.packs()[size_t(k)];
    const Mat3<Eight> now = deformed(nodal_gradient<d>(grid_, k, s, tile));
    Mat3<Eight>& before = increment_[size_t(k)];
    end_step<d>(laws_, pack, now * (inverse(before) * matrix_lanes(p.F, pack)), p);
    before = now;
  });
}

template <int d>
void ExplicitMpm<d>::step(double time, Particles& p) {
  grid_.update(p.x);
  const NodeMotion start = particles_to_grid<d>(grid_, p, scratch_);
  begin_packs(p);
  Array<double> v = start.velocity, u(grid_.nodes(), 3), force(u);
  const double delta = scene_.dt / substeps_;
  for (int k = 0; k < substeps_; ++k) {
    add_forces(p, force);
    for_each(grid_.nodes(), [&](int64_t i) {
      if (start.mass(i) == 0) return;
      for (int a = 0; a < d; ++a)
        v(i, a) += delta * (force(i, a) / start.mass(i) + scene_.gravity[size_t(a)]);
    });
    walls_.begin(grid_, scene_.walls, time + k * delta, delta);
    for_each(walls_.count(), [&](int64_t c) {
      double* own = v.row(walls_.node(c));
      const Vec3 m = walls_.allowed(c, {delta * own[0], delta * own[1], delta * own[2]}, nullptr);
      for (size_t a = 0; a < 3; ++a) own[a] = m[a] / delta;
    });
    for_each(u.size(), [&](int64_t i) { u.data()[i] += delta * v.data()[i]; });
    strain_particles(u, p);
  }
  grid_to_particles<d>(grid_, u, start.velocity, v, scene_.transfer, scene_.dt, p);
}

template class ExplicitMpm<2>;
template class ExplicitMpm<3>;

}  // namespace elastogen::mpm
