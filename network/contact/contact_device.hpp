// SPDX-License-Identifier: Apache-2.0
// Contact on the device: network/contact/contact.hpp with points, walls and all that is taken from a step
// in its memory. Each point gives a force, and each node of the surface gathers those of its points
// in their order: the same bits on every run. Nothing waits unless it says so.

#pragma once

#include "core/quaternion.hpp"
#include "network/potential/incremental_potential.hpp"

#include <memory>

namespace elastogen::cuda {

/// Stiffness of nodes of the surface in the nodes' frames, on the device.
struct NodalStiffness {
  const int32_t* nodes = nullptr;  ///< without pinned ones, (count)
  const double* blocks = nullptr;  ///< symmetric: xx, xy, xz, yy, yz, zz [N/m], (count, 6)
  int64_t count = 0;
};

/// Place of an entry of a symmetric 3x3 matrix among its six numbers.
ELASTOGEN_HD constexpr int symmetric_place(int i, int j) {
  return i + j + (i > 0 && j > 0 ? 1 : 0);
}

class DeviceContact {
 public:
  /// @param host  with contact; must outlive it.
  /// @throws Error (resources) where the device has no room.
  explicit DeviceContact(const PotentialTerms& host);
  ~DeviceContact();

  /// As Contact::begin_step; u on the device, as all arrays below.
  void begin_step(const double* u, double time);

  /// `clear` becomes `now` with what colliders run over carried along, and u is cut where the way
  /// there from `clear` leads into one, as in Solver::Impl::start. Waits for it.
  /// @return the collider that a point of `clear` lies in all the same, else null.
  const Collider* clear_start(const double* now, double* clear, double* u);

  /// As Contact::evaluate and deepest_overlap, read by the two below after synchronise().
  /// @param g  null: the energy alone.
  template <class T>
  void start_evaluation(const double* u, T* g);
  double energy() const;
  double deepest_overlap() const;

  /// Moves `end` back towards u where Contact::longest_step says so; share() is that of the way
  /// that is left, after synchronise().
  void cut_step(const double* u, double* end);
  double share() const;

  /// Freezes the stiffness at u.
  /// @param touching  false where the energy there is known to be 0: then there is none.
  void linearise(const double* u, bool touching);
  bool is_stiff() const;
  /// Adds the frozen Hessian times p to f.
  template <class T>
  void add_hessian_product(const T* p, T* f);
  /// Row sums of the frozen stiffness in the nodes' frames.
  /// @param rotation  (nodes, 9)
  NodalStiffness nodal_stiffness(const Quaternion<float>* rotation);
  /// The nodes of nodal_stiffness, on the host.
  const std::vector<int32_t>& surface_nodes() const;

  struct Impl;

 private:
  std::unique_ptr<Impl> impl_;
};

}  // namespace elastogen::cuda
