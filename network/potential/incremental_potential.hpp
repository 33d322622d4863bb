// SPDX-License-Identifier: Apache-2.0
// The incremental potential of a step, whose minimum is the next state:
//
//     Phi(u) = a0/(2 dt^2) sum_c m_c |u_c - uhat_c|^2 + sum_v W_v psi(F_v)
//              + E_hourglass + E_viscous + E_contact,
//
// u = x - X, and its gradient and Hessian products. The state is float64; the maths of the voxels
// runs in T = float or double on displacements relative to a node of the voxel's brick, so that
// float loses no digits to the motion of the body.

#pragma once

#include "core/held_nodes.hpp"
#include "core/node_loads.hpp"
#include "core/state.hpp"
#include "network/potential/brick_rows.hpp"
#include "network/potential/local_model.hpp"
#include "network/potential/potential_terms.hpp"

#include <memory>

namespace elastogen {

class IncrementalPotential : public PotentialTerms {
 public:
  /// @throws Error as PotentialTerms.
  explicit IncrementalPotential(const Scene& scene, LearnedLaws learned = {})
      : IncrementalPotential(PotentialTerms(scene, std::move(learned))) {}
  /// Sets the inertia of the terms' scheme, if they have one.
  explicit IncrementalPotential(PotentialTerms&& terms);

  /// Sets scheme and inertia alone, for objects that need only the Hessian at rest.
  void set_scheme(const StepScheme& scheme);

  /// Takes the loads at the end of a step or stage; before the calls below. Of the first stage the wind
  /// begins with that at its start.
  void begin_loads(const State& state, const StepScheme& scheme, bool first);
  void take_wind(const double* x, const double* v);  ///< as NodeLoads, with the predictor
  void relax_wind();
  const NodeLoads& loads() const { return loads_; }
  /// Sets the predictor, the frozen voxel rotations and the lagged normal forces of friction, all
  /// from the state at the start of the step.
  void begin_step(const State& state, const StepScheme& scheme);
  /// Of a stage, whose predictor is x + motion on free nodes; motion is (nodes, 3) [m]. The lag of
  /// friction is from the state, or from the displacement of the stage before.
  void begin_stage(const State& state, const StepScheme& scheme, const double* motion,
                   const double* stage_before);

  /// Sets the scheme and freezes everything at positions x [m], (nodes, 3), that do not move.
  void begin_still(In<double> x, const StepScheme& scheme);
  /// Energies of the voxels and forces on the free nodes [N] at u, without contact. After begin_still
  /// at u those of elasticity alone.
  PotentialValue voxel_forces(const double* u, double* forces);

  /// Sets the nodal rotations of the preconditioner, polar factors of the fill-weighted sum of F_v,
  /// from the start value of the iteration. They leave the axes of fixed components alone.
  void set_nodal_rotations(const double* u);

  /// Value and gradient [N], (nodes, 3), 0 on pinned nodes, at displacement u; null: the value
  /// alone. u of dependent nodes follows that of their parent nodes (held()), here and in all that
  /// follows; the gradient by parent nodes has their share in it, and dependent nodes 0.
  template <class T>
  PotentialValue evaluate(const double* u, T* gradient);

  /// evaluate in float64 with the smallest Jacobians, for the certificate. It finds reactions().
  PotentialValue residual(const double* u, double* gradient);
  /// Of each holder of the scene, at the last residual().
  const std::vector<Reaction>& reactions() const { return reactions_; }
  /// Where holders put nodes at the end of the step or stage.
  const HeldNodes& held() const { return held_; }

  /// Freezes the Hessian at u; contact is projected for both kinds. hessian_product then gives A p,
  /// 0 on pinned nodes.
  void linearise(const double* u, TangentKind kind = TangentKind::kProjected);
  /// The part of linearise that belongs to the contact.
  void linearise_contact(const double* u) { contact_.linearise(u); }
  void hessian_product(const float* p, float* product);

  /// Product with the Hessian at rest, in float64, without contact.
  void rest_hessian_product(const double* p, double* product);

  const BrickRows& rows() const { return *rows_; }
  /// rows() for objects that share them or outlive the potential.
  std::shared_ptr<const BrickRows> shared_rows() const { return rows_; }
  /// Predictor uhat = xhat - X [m], (nodes, 3); of pinned nodes where they are held.
  const Zeroed<double>& predictor() const { return predictor_; }
  /// Displacement at the start of the step [m], (nodes, 3).
  const Zeroed<double>& now() const { return now_; }
  /// Strains that the rate of damping is measured from, [row][18][lane]; empty: none is damped.
  const Zeroed<double>& strain_before() const { return strain_before_; }
  /// Nodal rotations, (nodes, 9).
  const Zeroed<float>& nodal_rotation() const { return nodal_rotation_; }
  /// Inertial diagonal a0 m / dt^2 [N/m] of a node, and of all, (nodes).
  double inertia(int64_t node) const { return inertia_[size_t(node)]; }
  const Zeroed<double>& inertia() const { return inertia_; }
  /// Fill and variance weights of the voxels, [row][5][lane].
  const Zeroed<double>& voxel_weights() const { return weights_; }
  /// Data of the voxels of a row besides their displacement; T float or double.
  template <class T>
  void read_voxel_data(int64_t row, VoxelData<Pack<T>>& data) const;

 private:
  friend class VoxelStiffness;
  struct Sums {
    Pack<double> elastic = {}, hourglass = {}, viscous = {};
    Pack<double> min_j = Pack<double>{} + 1e300, min_corner_j = min_j;
    Pack<double> outside = {};
  };
  /// Whether a node keeps its position, whatever others do.
  bool is_fixed(int64_t n) const { return scene_.pinned(n) == kPinnedNode; }
  void fill_weights();
  template <class Motion>
  void begin(In<double> x, const Motion& motion);
  void add_loads_to_predictor(double share);
  void rotations(const double* u, Zeroed<double>& result);
  void find_strains(const double* u, Zeroed<double>& strains);
  void begin_damping(const State& state, double weight, const double* other);
  /// beta of the damping of a material in the present step.
  double beta_of(int32_t material) const {
    return has_damping() ? viscous_time(scene_.materials[size_t(material)]) * rate_of(scheme_) : 0;
  }
  template <class T>
  bool read_damping(int64_t row, VoxelDamping<Pack<T>>& damping) const;
  uint32_t full_lanes(int64_t row) const;
  template <class T>
  static void add_energy(const VoxelEnergy<Pack<T>>& e, const Pack<T>& fill, Sums& sums);
  template <class T, bool kQuality>
  PotentialValue evaluate_all(const double* u, T* gradient);
  double inertial_energy(const double* u) const;
  void deformation_gradients(const double* u, Zeroed<double>& F);

  std::shared_ptr<const BrickRows> rows_;
  Zeroed<double> weights_;    ///< phi, c_xy, c_yz, c_zx, c_xyz, [row][5][lane]
  Zeroed<double> rotation_;   ///< R_v, [row][9][lane]
  Zeroed<double> gradients_;  ///< F_v of set_nodal_rotations, or their rotations, [row][9][lane]
  Zeroed<float> nodal_rotation_;
  Zeroed<double> predictor_, inertia_, now_;
  Zeroed<float> tangent_;                   ///< [row][45][lane]; filled by linearise
  Zeroed<double> strain_before_, strains_;  ///< E_b, A_b and scratch, [row][18][lane]
  BrickScratch<float> scratch_float_;
  BrickScratch<double> scratch_double_;
  HeldNodes held_;
  NodeLoads loads_;
  std::vector<Reaction> reactions_;
  std::vector<Sums> sums_;
  std::vector<NoSums> no_sums_;
};

}  // namespace elastogen
