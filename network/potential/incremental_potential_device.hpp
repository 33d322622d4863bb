// SPDX-License-Identifier: Apache-2.0
// The incremental potential of a step on the device: energy and gradient by the formulas of
// local_model.hpp, from tables that are uploaded once for a scene, and contact
// (contact_device.hpp).

#pragma once

#include "core/quaternion.hpp"
#include "network/contact/contact_device.hpp"

#include <memory>

namespace elastogen::cuda {

class DeviceHeldNodes;

/// Terms of the inertial energy, for callers that sum it along with other numbers.
struct InertiaTerms {
  const double *inertia, *predictor;  ///< of DevicePotential
  const uint8_t* pinned;
  double* total;  ///< where value() reads the sum

  /// Energy at kCount numbers k = 3 node + component of u, from `first` on.
  template <int kCount>
  ELASTOGEN_HD double energy(int64_t first, const double u[kCount],
                             const double aim[kCount]) const {
    double weight[kCount], sum = 0;
    for (int j = 0; j < kCount; ++j) {
      const int64_t node = (first + j) / 3;
      weight[j] = pinned[node] == kPinnedNode ? 0 : inertia[node] / 2;
    }
    for (int j = 0; j < kCount; ++j) sum += weight[j] * (u[j] - aim[j]) * (u[j] - aim[j]);
    return sum;
  }
};

/// Most nodes of a level that is solved, if nothing changes its operators. The solve is faster than
/// the coarser levels would be: it reads the inverses, 12 B for each pair of nodes, once.
inline constexpr int64_t kDenseNodes = 3072;
/// That limit where they change, so that the inverses are made anew.
inline constexpr int64_t kMostChangedNodes = 100;

/// Whether the operators of the preconditioner change, with contact or with the length of steps.
inline bool operators_change(const Scene& scene) {
  return !scene.colliders.empty() || has_stages(scene.scheme);
}

class DevicePotential {
 public:
  /// Has the inertia of the terms' scheme, if they have one; the terms must outlive it.
  /// @param dense  most nodes of a level that is solved (multigrid.hpp), if operators do not change.
  /// @throws Error (resources) if the device has too little memory.
  explicit DevicePotential(const PotentialTerms& terms, int64_t dense = kDenseNodes);
  ~DevicePotential();

  /// Copies predictor and inertia from a potential of the host after its begin_step, and finds
  /// frozen rotations and contact from the displacement at the start of the step.
  void begin_step(const IncrementalPotential& host);

  // data of a step's start, on the device, for callers that fill them there
  void set_scheme(const StepScheme& scheme);  ///< inertia alone
  double* inertia();                          ///< a0 m / dt^2 [N/m], (nodes)
  double* predictor();                        ///< xhat - X [m], (nodes, 3)
  double* load();                             ///< [N], (nodes, 3); null: none acts
  /// Finds the frozen rotations from the displacement at the start of the step.
  void freeze_rotations(const double* u);

  /// Begins the damping of a step from the displacement at its start; `other` is that of the step
  /// before, or of the first stage where this is the second one. Nothing where none is damped.
  void begin_damping(const StepScheme& scheme, const double* now, const double* other);

  /// Finds the nodal rotations of the preconditioner, in float, from a displacement on the device.
  void set_nodal_rotations(const double* u);

  /// Value, and gradient [N], (nodes, 3), 0 on pinned nodes, unless that is null; both arrays on
  /// the device. As in IncrementalPotential u of dependent nodes follows that of their parent
  /// nodes, which have their share of the gradient.
  template <class T>
  PotentialValue evaluate(const double* u, T* gradient);
  /// As evaluate() without the wait: value() is complete when the launched kernels have ended.
  template <class T>
  void start_evaluation(const double* u, T* gradient);
  /// Starts the value alone, in float, into one of kEnergies places; contact has only one place.
  void start_energy(const double* u, int place);
  /// Waits for the value of the last start_energy().
  void wait_for_energy();
  static constexpr int kEnergies = 3;
  /// As start_evaluation() without the inertial energy, which the caller sums.
  template <class T>
  void start_gradient(const double* u, T* gradient);
  InertiaTerms inertia_terms();
  /// As start_evaluation() in float64, with the smallest Jacobians; for the certificate.
  void start_residual(const double* u, double* gradient);
  /// As IncrementalPotential::reactions(), when the kernels of start_residual() have ended.
  std::vector<Reaction> reactions() const;
  PotentialValue value(int place = 0) const;

  /// Freezes the Hessian at u, in float; hessian_product then gives A p, 0 on pinned nodes. All
  /// arrays are (nodes, 3), on the device.
  /// @param touching  false where the contact energy at u is known to be 0.
  void linearise(const double* u, TangentKind kind = TangentKind::kProjected, bool touching = true);
  template <class T>
  void hessian_product(const T* p, T* product);
  /// Bytes of device memory that the first linearise allocates.
  size_t tangent_bytes() const;

  /// Null where the scene has no colliders.
  DeviceContact* contact();

  /// Tables of the voxels and their weights; for tests.
  BrickRows download_rows() const;
  std::vector<double> download_weights() const;

  int64_t nodes() const;
  const uint8_t* pinned() const;  ///< NodeKind, (nodes), on the device
  DeviceHeldNodes& held();        ///< at the end of the step or stage: the caller sets its time
  const DeviceHeldNodes& held() const;
  const Quaternion<float>* nodal_rotation() const;  ///< (nodes), on the device
  const double* rest() const;                       ///< [m], (nodes, 3), on the device
  const double* mass() const;                       ///< [kg], (nodes), on the device
  const double* load() const;                       ///< [N], (nodes, 3), on the device; null: none
  const PotentialTerms& terms() const;

  struct Impl;
  Impl& impl() { return *impl_; }  ///< for other operators on the same tables

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::cuda
