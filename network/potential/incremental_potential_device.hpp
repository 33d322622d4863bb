// SPDX-License-Identifier: Apache-2.0
// The incremental potential of a step on the device: energy and gradient by the maths of
// local_model.hpp, from tables that are uploaded once a scene, and contact (contact_device.hpp).

#pragma once

#include "core/quaternion.hpp"
#include "network/contact/contact_device.hpp"

#include <memory>

namespace elastogen::cuda {

/// What the inertial energy is a sum of, for those who take it along with other sums.
struct InertiaTerms {
  const double *inertia, *predictor;  ///< of DevicePotential
  const uint8_t* pinned;
  double* total;  ///< where value() looks for the sum

  /// At numbers k = 3 node + component of u, from `first` on.
  template <int kCount>
  ELASTOGEN_HD double energy(int64_t first, const double u[kCount],
                             const double aim[kCount]) const {
    double weight[kCount], sum = 0;
    for (int j = 0; j < kCount; ++j) {
      const int64_t node = (first + j) / 3;
      weight[j] = pinned[node] ? 0 : inertia[node] / 2;
    }
    for (int j = 0; j < kCount; ++j) sum += weight[j] * (u[j] - aim[j]) * (u[j] - aim[j]);
    return sum;
  }
};

/// Where nothing changes it, a level of so many nodes is solved faster than the levels below it are
/// walked through: its inverses, 12 B a pair of nodes, are read once.
inline constexpr int64_t kDenseNodes = 3072;

class DevicePotential {
 public:
  /// With the inertia of the terms' scheme, if they have one; the terms must outlive it.
  /// @param dense  nodes at most of a level that is solved (network/precondition/multigrid.hpp); with colliders
  ///               it is that of the host.
  /// @throws Error (resources) where the device has no room.
  explicit DevicePotential(const PotentialTerms& terms, int64_t dense = kDenseNodes);
  ~DevicePotential();

  /// Takes predictor and inertia from a potential of the host after its begin_step, and frozen
  /// rotations and contact from the displacement at the start of the step.
  void begin_step(const IncrementalPotential& host);

  // what a step begins with, on the device, for those who fill it there
  void set_scheme(const StepScheme& scheme);  ///< inertia alone
  double* inertia();                          ///< a0 m / dt^2 [N/m], (nodes)
  double* predictor();                        ///< xhat - X [m], (nodes, 3)
  /// Takes the frozen rotations from a displacement, that at the start of the step.
  void freeze_rotations(const double* u);

  /// Nodal rotations of the preconditioner from a displacement on the device, in float.
  void set_nodal_rotations(const double* u);

  /// Value, and gradient [N], (nodes, 3), 0 on pinned nodes, unless that is null; both arrays on
  /// the device.
  template <class T>
  PotentialValue evaluate(const double* u, T* gradient);
  /// The same without waiting for it: value() is there once kernels behind it have ended.
  template <class T>
  void start_evaluation(const double* u, T* gradient);
  /// The value in float alone, to one of kEnergies places; those of contact have a single one.
  void start_energy(const double* u, int place);
  /// Waits for the one that was started last.
  void wait_for_energy();
  static constexpr int kEnergies = 3;
  /// The same but for the inertial energy, which the caller sums.
  template <class T>
  void start_gradient(const double* u, T* gradient);
  InertiaTerms inertia_terms();
  /// That in float64 with the smallest Jacobians, for the certificate.
  void start_residual(const double* u, double* gradient);
  PotentialValue value(int place = 0) const;

  /// Freezes the Hessian at u, in float; hessian_product then gives A p, 0 on pinned nodes. All
  /// arrays are (nodes, 3), on the device.
  /// @param touching  false where the contact energy at u is known to be 0.
  void linearise(const double* u, TangentKind kind = TangentKind::kProjected, bool touching = true);
  template <class T>
  void hessian_product(const T* p, T* product);
  /// What the first linearise takes of the device's memory.
  size_t tangent_bytes() const;

  /// Null where the scene has no colliders.
  DeviceContact* contact();

  /// Tables of its voxels and their weights, for tests.
  BrickRows download_rows() const;
  std::vector<double> download_weights() const;

  int64_t nodes() const;
  const uint8_t* pinned() const;                    ///< (nodes), on the device
  const Quaternion<float>* nodal_rotation() const;  ///< (nodes), on the device
  const double* rest() const;                       ///< [m], (nodes, 3), on the device
  const double* mass() const;                       ///< [kg], (nodes), on the device
  const PotentialTerms& terms() const;

  struct Impl;
  Impl& impl() { return *impl_; }  ///< for other operators on the same tables

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::cuda
