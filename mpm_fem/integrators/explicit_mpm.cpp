// SPDX-License-Identifier: Apache-2.0
#include "mpm_fem/integrators/explicit_mpm.hpp"

#include "core/error.hpp"
#include "mpm_fem/mpm/g2p.hpp"
#include "mpm_fem/mpm/point_update.hpp"

#include <algorithm>

namespace elastogen::mpm {
namespace {

Mat3<double> symmetric_at(const Array<double>& all, int64_t k) {
  const double* s = all.row(k);
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

/// Forces of the particles' stress on the nodes [N].
template <int d>
void ExplicitMpm<d>::add_forces(const Particles& p, Array<double>& force) {
  scatter<d>(
      grid_, p.x, scratch_, force, [&](int32_t k, const Spline<d>& s, int place, double* tile) {
        Mat3<double> A =
            times_transposed(symmetric_at(p.stress, k), inverse(load_matrix(increment_.row(k))));
        for (double& a : A.m) a *= -p.volume(k);
        add_nodal_product<d>(s, place, A, tile);
      });
}

/// Strain, stress and history of the particles when the nodes have moved so far since the transfer.
template <int d>
void ExplicitMpm<d>::strain_particles(const Array<double>& motion, Particles& p) {
  gather<d>(grid_, p.x, motion, [&](int32_t k, const Spline<d>& s, int place, const double* tile) {
    Mat3<double> now = nodal_gradient<d>(s, place, tile);
    for (int a = 0; a < 3; ++a) now(a, a) += 1;
    Mat3<double> F = load_matrix(p.F.row(k));
    F = now * (inverse(load_matrix(increment_.row(k))) * F);
    std::visit([&](const auto& law) { end_step<d>(law, F, p.history(k), p.stress.row(k)); },
               laws_[size_t(p.solid(k))]);
    store_matrix(F, p.F.row(k));
    store_matrix(now, increment_.row(k));
  });
}

template <int d>
void ExplicitMpm<d>::step(double time, Particles& p) {
  grid_.update(p.x);
  const NodeMotion start = particles_to_grid<d>(grid_, p, scratch_);
  if (increment_.rows() != p.count()) increment_ = Array<double>(p.count(), 9);
  for (int64_t k = 0; k < p.count(); ++k) store_matrix(identity<double>(), increment_.row(k));
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
