// SPDX-License-Identifier: Apache-2.0
// The motion of nodes in a step of stages, relative to rigid references (core/time_stage.hpp): loose
// pieces are carried by the rigid motion that they begin the step with (core/rigid_motion.hpp), as
// far as prescribed components admit it, pieces with pins turn about these as they do at its start
// and as that changed in the last step. Pieces that are moved have none. References of dependent
// nodes follow from those of their parent nodes. Prescribed components have predictors of their own,
//
//     uhat = u + k^2 (g - u''),
//
// so that the inertia M (u - uhat)/k^2 is that of their motion and their weight. Dependent nodes have
// those of their own state, like free ones.

#pragma once

#include "core/ledger.hpp"
#include "core/time_error.hpp"
#include "mpm_fem/integrators/fem_pieces.hpp"
#include "mpm_fem/integrators/fem_state.hpp"

namespace elastogen::fem {

class StageMotion {
 public:
  /// Both must outlive it.
  StageMotion(const FemScene& scene, const FemPieces& pieces);

  /// Begins a step from a state, which must stay as it is to its end.
  void begin(const FemState& state);
  /// Begins a stage of the step; after keep_stage() its second one.
  void begin_stage(const TimeStage& stage);
  /// Keeps the displacements at the end of the first stage of SDIRK2.
  void keep_stage(const Array<double>& u);

  /// uhat [m], (nodes, 3).
  const Array<double>& predictor() const { return predictor_; }
  /// Displacements at which the minimum may lie near: uhat without the inertia of turning, which
  /// elastic forces balance, and those of a constant velocity relative to the reference.
  std::vector<Array<double>> starts() const;
  /// Velocities at the end of the stage [m/s], where displacements are u.
  Array<double> velocities(const Array<double>& u) const;

  // of a step whose velocities are v at its end

  /// e = v - z' there; 0 at prescribed components, and dependent nodes follow their parent nodes.
  Array<double> relative(const Array<double>& v) const;
  /// Combination of e at the end, at the start and at the other point; 0 at prescribed components, and
  /// dependent nodes follow.
  Array<double> combined(const StepWeights& weights, const Array<double>& v) const;

  /// What momentum and angular momentum about a point of the references gain in the step beyond their
  /// integral by its stages, at free components of pieces with pins. After the last stage.
  /// @param mass  M 1 [kg], (nodes, 1)
  TwoMomenta gain_of_references(const Vec3& about, const Array<double>& mass) const;

  const TimeStage& stage() const { return stage_; }
  /// The pieces at the start of the step and, for BDF2, at the start of the one before.
  const std::vector<PieceMotion>& now() const { return now_; }
  const std::vector<PieceMotion>& before() const { return before_; }
  /// Turns about pins at the start of the step [rad/s].
  const std::vector<Vec3>& turns() const { return turn_; }

 private:
  /// The reference at a time after the start of the step: z - x0, z' and z'', (nodes, 3).
  struct Reference {
    Array<double> shift, velocity, acceleration;
  };

  Reference reference_at(double t) const;
  void find_turns();
  void set_other(double t_b);
  void prescribe();
  bool is_fixed(int64_t k) const { return !scene_.fixed.empty() && scene_.fixed.data()[k]; }

  const FemScene& scene_;
  const FemPieces& pieces_;
  const FemState* state_ = nullptr;
  TimeStage stage_;
  std::vector<PieceMotion> now_, before_;
  std::vector<Vec3> turn_;
  std::vector<double> gain_;       // of the turns [rad/s^2]
  Reference end_;                  // at the end of the stage
  Array<double> e_0_, d_b_, e_b_;  // (nodes, 3)
  Array<double> predictor_;
  Array<double> given_velocity_;  // of prescribed components at the end of the stage
};

}  // namespace elastogen::fem
