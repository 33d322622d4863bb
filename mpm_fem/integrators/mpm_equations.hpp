// SPDX-License-Identifier: Apache-2.0
// The equations of an implicit step of the material point method on the nodes of a grid. With u the
// motion of a node in the step, uhat = dt v_i^n + dt^2 g,
//
//     R(u) = M (u - uhat)/dt^2 + sum_p V_p P(F_p) Fe_p^nT grad w_ip,
//     F_p  = (I + sum_i u_i (x) grad w_ip) Fe_p^n,
//
// P is the stress of the law with plastic flow. At colliders Pi(m) is the part of a motion m that
// contact with friction allows (ObstacleContact::allowed), and the step solves u = Pi(u - dt^2 M^-1
// R). All of it is scaled by the masses, y = M^1/2 u, so that nodes with almost no mass are like
// the others:
//
//     r(y) = (y - M^1/2 Pi(M^-1/2 (y - dt^2 r0)))/dt^2,   r0 = M^-1/2 R(M^-1/2 y),
//
// which is r0 at nodes without colliders. [r] = sqrt(kg) m/s^2.

#pragma once

#include "core/principal.hpp"
#include "mpm_fem/integrators/mpm_jacobian.hpp"
#include "mpm_fem/mpm/mpm_scene.hpp"
#include "mpm_fem/mpm/p2g.hpp"
#include "mpm_fem/mpm/pack_laws.hpp"

#include <vector>

namespace elastogen::mpm {

template <int d>
class MpmEquations {
 public:
  /// The scene must outlive it.
  /// @throws Error as check_scene and point_law
  explicit MpmEquations(const MpmScene& scene);
  virtual ~MpmEquations() = default;
  MpmEquations(const MpmEquations&) = delete;

  /// Sets the state at the start of a step of dt from `time`. The particles must stay until the
  /// next begin().
  void begin(const Particles& particles, double time, double dt);

  int64_t unknowns() const { return 3 * grid_.nodes(); }
  const ParticleGrid<d>& grid() const { return grid_; }
  const std::vector<PointLaw<d>>& laws() const { return laws_; }
  /// |M g|_{M^-1} of g = 9.81 m/s^2, the unit of residuals [sqrt(kg) m/s^2].
  double reference() const { return reference_; }

  /// y of the motion without stress, Pi(uhat).
  void predict(double* y) const;
  /// u [m], (nodes, 3), of y.
  void motion(const double* y, Out<double> u) const;

  void residual(const double* y, double* r);
  /// Bound on the rounding error of r at y, 2-norm.
  double noise(const double* y);
  /// Largest share, at most 1, of the path from y to `end` that leaves every particle a tenth of
  /// the volume it has at y (share_before_inversion).
  double longest_step(const double* y, const double* end);

  /// Prepares products with dr/dy at y. Call residual(y) before.
  void linearise(const double* y);
  void product(const double* p, double* Jp);
  /// z = B^-1 p, B the blocks of each node of dr/dy with the frozen tangent (frozen_hessian).
  void precondition(const double* p, double* z) const;
  /// dr/dy where it was linearised last.
  const fem::SparseMatrix& jacobian();
  /// A number that changes with the pattern of jacobian().
  int64_t pattern_version() const { return cells_.version(); }

  /// Updates strain, stress and history of the particles of begin() for a motion y of the nodes.
  void commit(const double* y, Particles& particles);
  /// After commit(): begins another step of dt, from `time`, on the same nodes.
  void go_on(double time);
  /// After commit(): updates places and velocities of the particles.
  void transfer(Particles& particles) const;

 protected:
  struct Start {  // of a pack; its trial is (moved + grad u) F
    Mat3<Eight> F;
    Mat3<Eight> moved;  // I + the gradient of the motion between begin and go_on
    Eight volume;       // [m^3], 0 beyond its count

    Mat3<Eight> after(Mat3<Eight> gradient) const {
      for (int e = 0; e < 9; ++e) gradient.m[e] += moved.m[e];
      return gradient;
    }
  };
  /// Stress P of a pack's particles at their trial F.
  virtual Mat3<Eight> piola(int64_t pack, const Mat3<Eight>& F);
  /// Derivative of the stress in the principal frame of F.
  virtual PrincipalHessian<Eight, Mat3<Eight>> piola_derivative(int64_t pack, const Svd3<Eight>& F,
                                                                Eight t[3]);
  /// Fills obstacle_tangent_ at y.
  virtual void linearise_obstacles(const double* y);
  /// The motion that the k-th node at a collider would have in the step without it: y - dt^2 r0,
  /// unscaled [m].
  Vec3 free_motion(int64_t k, const double* y) const;
  /// r0 at y.
  void equilibrium(const double* y, double* r0);
  /// Motion of a node without stress and colliders [m].
  double predicted(int64_t node, int a) const {
    return dt_ * start_.velocity(node, a) + (a < d ? dt_ * dt_ * scene_.gravity[size_t(a)] : 0);
  }

  const MpmScene& scene_;
  std::vector<PointLaw<d>> laws_;
  ParticleGrid<d> grid_;
  const Particles* particles_ = nullptr;
  double dt_ = 0;
  NodeMotion start_;  // with the present velocity
  ObstacleContact obstacles_;
  std::vector<double> root_mass_, inverse_root_;  // sqrt(m_i), its inverse or 0
  std::vector<Mat3<double>> obstacle_tangent_;    // dPi of each node at a collider
  std::vector<Start> pack_;
  std::vector<double> r0_;
  Array<double> u_;  // (nodes, 3)

 private:
  struct Tangent {  // of a pack: dA = V dP Fe^T in the gradient of u
    PrincipalHessian<Eight, Mat3<Eight>> hessian;
    Svd3<Eight> frame;  // U and Fe^n V, so that core/principal.hpp's apply is from gradient to A
  };
  void add_stress(bool magnitude);
  PrincipalHessian<Eight> set_tangent(int64_t pack, const Mat3<Eight>& gradient);
  void invert_blocks(In<double> sums);
  void put_obstacle(int64_t node, const Mat3<double>& D);
  void apply_obstacles(const double* free, double* result) const;

  double reference_ = 0;
  Array<double> motion_, before_;  // of the nodes since begin [m], their velocity then, (nodes, 3)
  std::vector<Tangent> tangent_;
  std::vector<Mat3<double>> inverse_block_;
  CellAssembly<d> cells_;
  fem::SparseMatrix jacobian_;
  bool has_cells_ = false;  // cells_ are those of the step
  Array<double> force_;     // (nodes, 3)
  Zeroed<double> scratch_;
};

extern template class MpmEquations<2>;
extern template class MpmEquations<3>;

}  // namespace elastogen::mpm
