// SPDX-License-Identifier: Apache-2.0
// The mesh number: by how much a body is displaced wrongly because its voxels have the edge h. It is
// the difference d to the same body on voxels of 2h, to first order. With x_c the positions of h on
// the nodes of 2h, f the forces of elasticity and P the prolongation,
//
//     t = P^T f_h(x_h) - f_2h(x_c),     K d = t           of an equilibrium,
//                                       M d'' + K d = t   of a motion, with d = 0 at its start,
//
// K the projected Hessian of 2h at x_c. Loads and contact act alike on both grids and stand in
// f_h(x_h). d is carried by BDF2, a step from estimate to estimate, and turns with its piece. What a
// method of second order calls the error of h is d/3; bodies of few voxels, whose error falls more
// slowly, ask for no divisor (docs/how_right.md).

#pragma once

#include "core/mesh_error.hpp"
#include "core/pcg.hpp"
#include "network/mesh_number/coarse_scene.hpp"
#include "network/precondition/preconditioner.hpp"
#include "network/step/piece_sums.hpp"
#include "voxelize/embedding.hpp"

namespace elastogen {

/// Least det F on 2h over the least on h (over 1 where that is more) of an estimate to be trusted.
inline constexpr double kTrustedJ = 0.7;

class MeshNumber {
 public:
  /// @param scene     finished; must outlive it. Damping counts, contact and nets do not.
  /// @param interval  usual time between estimates [s]; 0: equilibria.
  /// @param fixed     1 where a component is held or moved by the scene, (nodes, 3).
  /// @throws Error as finish_scene, on the grid of 2h.
  MeshNumber(const Scene& scene, double interval, const Array<uint8_t>& fixed);
  /// With the nodes that the scene pins.
  MeshNumber(const Scene& scene, double interval);
  MeshNumber(const MeshNumber&) = delete;

  /// Starts a motion: d = 0. @param x  positions [m], (nodes, 3).
  void begin(In<double> x);

  /// The number at positions x, an interval [s] after the last call; that of an equilibrium needs
  /// none. Same bits at any number of threads.
  MeshError estimate(In<double> x, double interval, const Embedding& points);

  const Scene& coarse() const { return coarse_.scene; }
  /// The last d [m], (nodes of 2h, 3).
  const Zeroed<double>& difference() const { return d_; }

 private:
  void find_defect(In<double> x);
  enum class Rigid { kForces, kMotion };
  /// A rigid motion: push + twist x (x - centre).
  struct RigidPart {
    Vec3 centre = {}, push = {}, twist = {};
  };
  template <class Force>
  RigidPart rigid_part(size_t piece, const Force& f) const;
  void take_rigid(Zeroed<double>& field, Rigid kind);
  void turn();
  StepScheme scheme_of(double interval) const;
  double find_right_side(const StepScheme& scheme);
  void solve(double interval);
  void product(const float* p, float* Ap);
  void mask(float* values) const;
  MeshError judge(const Embedding& points);

  const Scene& scene_;
  Array<uint8_t> fixed_;
  CoarseScene coarse_;
  Pieces pieces_;
  IncrementalPotential potential_, coarse_potential_;
  Preconditioner<double> preconditioner_;
  PcgWork<float> pcg_;
  bool moves_;
  double last_interval_ = 0, least_j_ = 1;
  Zeroed<double> u_, forces_;            // of h: displacement, later P d; forces
  Zeroed<double> uc_, before_, defect_;  // of 2h: displacement of x_c, now and before; t
  Zeroed<double> d_, v_, d_before_, v_before_, start_;
  Array<double> xc_;
  std::vector<float> right_, step_;
};

}  // namespace elastogen
