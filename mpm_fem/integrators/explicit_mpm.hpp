// SPDX-License-Identifier: Apache-2.0
// Explicit steps of the material point method: symplectic Euler on the nodes of a grid,
//
//     v_i += delta (f_i/m_i + g),   f_i = -sum_p V_p tau_p Finc_p^-T grad w_ip,
//
// m times with delta = dt/m from one transfer to the next, on nodes that do not move: u_i += delta
// v_i, Finc_p = I + sum_i u_i (x) grad w_ip, and the law after each. m = 1 is the usual explicit
// step. Transfers smooth velocities, so it has no limit for dt -> 0. For m -> infinity at fixed dt
// it converges, to the time integral of the equations that the implicit step discretises.

#pragma once

#include "mpm_fem/mpm/mpm_scene.hpp"
#include "mpm_fem/mpm/p2g.hpp"

namespace elastogen::mpm {

template <int d>
class ExplicitMpm {
 public:
  /// The scene must outlive it.
  /// @throws Error as check_scene and point_law, and on substeps below 1.
  explicit ExplicitMpm(const MpmScene& scene, int substeps = 1);

  /// Advances by scene.dt from `time` [s].
  /// @throws Error (resources) as ParticleGrid::update
  void step(double time, Particles& particles);

  /// Largest delta that is stable for most scenes, 0.5 h/c [s] of the fastest solid.
  double stable_step() const;

 private:
  Mat3<Eight> force_of(int64_t pack, const Particles& particles) const;
  void add_forces(const Particles& particles, Array<double>& force);
  void strain_particles(const Array<double>& motion, Particles& particles, Array<double>& force);
  void end_pack(int64_t pack, const Mat3<Eight>& now, Particles& particles);
  void end_lanes(int64_t pack, int begin, const Mat3<WidePack>& now, Particles& particles);
  void move_nodes(double time, double delta, const NodeMotion& start, const Array<double>& force,
                  Array<double>& v, Array<double>& u);

  const MpmScene& scene_;
  int substeps_;
  std::vector<PointLaw<d>> laws_;
  ParticleGrid<d> grid_;
  ObstacleContact obstacles_;
  std::vector<Mat3<Eight>> increment_;  // Finc of each pack; empty: I
  Zeroed<double> scratch_;
};

extern template class ExplicitMpm<2>;
extern template class ExplicitMpm<3>;

}  // namespace elastogen::mpm
