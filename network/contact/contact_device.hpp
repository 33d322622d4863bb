// SPDX-License-Identifier: Apache-2.0
// Contact on the device: contact.hpp with points, colliders and the data of a step's start
// in device memory. One pass finds the force of each point; then each node of the surface gathers
// the forces of its points in a fixed order, so that every run gives the same bits. Functions wait
// for the device only where their comment says so.

#pragma once

#include "core/quaternion.hpp"
#include "network/potential/incremental_potential.hpp"

#include <memory>

namespace elastogen::cuda {

/// Stiffness of surface nodes in the frames of the nodes, on the device.
struct NodalStiffness {
  const int32_t* nodes = nullptr;  ///< without those that keep their positions, (count)
  const double* blocks = nullptr;  ///< symmetric: xx, xy, xz, yy, yz, zz [N/m], (count, 6)
  int64_t count = 0;
};

/// Index of entry (i, j) of a symmetric 3x3 matrix among its six numbers.
ELASTOGEN_HD constexpr int symmetric_place(int i, int j) {
  return i + j + (i > 0 && j > 0 ? 1 : 0);
}

class DeviceHeldNodes;
struct FrozenStiffness;  // contact_view.cuh

class DeviceContact {
 public:
  /// @param host  terms with contact; they must outlive this object.
  /// @throws Error (resources) if the device has too little memory.
  explicit DeviceContact(const PotentialTerms& host);
  ~DeviceContact();

  /// As Contact::begin_step; u on the device, as all arrays below.
  void begin_step(const double* u, double time);

  // steps of stages, as in Contact, for a scene that has them
  void begin_stage(const double* u, double time, double dt, const double* of_lag, double lag_time);
  bool renew_lag(const double* u);  ///< waits for the device
  void relax_lag(double share);
  void keep_bonds(const double* u);
  void forget_bonds();
  void download_bonds(Array<double>& bonds) const;  ///< Contact::bonds; waits for the device
  /// Waits for the device.
  ActionSums act(const double* u, const double* v, const double* v_stage,
                 const std::vector<Vec3>& about);

  /// Copies `now` to `clear` and moves nodes that colliders run over along with them. Then cuts the
  /// step from `clear` to u where its path leads into a collider, as Solver::Impl::start does.
  /// Waits for the device.
  /// @param held  follows what moves along.
  /// @return the collider whose core still contains a point of `clear`, else null.
  const Collider* clear_start(const double* now, double* clear, double* u,
                              const DeviceHeldNodes& held);

  /// Starts Contact::evaluate and deepest_overlap. energy() and deepest_overlap() give their
  /// results after synchronise().
  /// @param g  null: the energy alone.
  template <class T>
  void start_evaluation(const double* u, T* g);
  /// Adds the forces of the last start_evaluation() at pinned nodes, in a scene with holders.
  void add_pinned_forces(double* g);
  double energy() const;
  double deepest_overlap() const;

  /// Moves `end` back towards u by the share of Contact::longest_step. share() gives that share
  /// after synchronise().
  void cut_step(const double* u, double* end);
  double share() const;

  /// Freezes the stiffness at u.
  /// @param touching  false if the contact energy at u is known to be 0: then the stiffness is 0.
  void linearise(const double* u, bool touching);
  bool is_stiff() const;
  /// Adds the frozen Hessian times p to f.
  template <class T>
  void add_hessian_product(const T* p, T* f);
  /// Row sums of the frozen stiffness in the nodes' frames, times a share; 0 at dependent nodes.
  /// @param rotation  (nodes)
  /// @param pinned    NodeKind, (nodes)
  /// @param share     a number on the device
  NodalStiffness nodal_stiffness(const Quaternion<float>* rotation, const uint8_t* pinned,
                                 const double* share);
  /// The frozen stiffness between nodes, for kernels.
  FrozenStiffness frozen_stiffness();
  /// The nodes of nodal_stiffness, on the host.
  const std::vector<int32_t>& surface_nodes() const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::cuda
