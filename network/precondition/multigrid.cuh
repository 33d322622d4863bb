// SPDX-License-Identifier: Apache-2.0
// The V-cycle of network/precondition/multigrid.hpp on the device, on levels that are made there
// (multigrid_grid.cuh). Launches do not wait for the device. A level that fills the card has a
// kernel for each pass; the small levels share one kernel, a cluster of blocks (compute capability
// 9.0).

#pragma once

#include "network/contact/contact_device.hpp"
#include "network/potential/incremental_potential_device.hpp"
#include "network/precondition/multigrid.hpp"

#include <functional>
#include <memory>
#include <vector>

namespace elastogen::cuda {

template <class T>
struct DeviceMultigridLevels;

template <class T>
struct ResidualInput;  // stencil.cuh

/// Work that runs beside the coarser levels of a cycle, which leave most of the card idle.
template <class T>
struct Companion {
  std::function<void()> begin;  ///< launches it, behind the finest level's residual
  std::function<void()> end;    ///< makes later launches wait for it
  const T* result = nullptr;    ///< its result by node, (nodes, 3), which is added to z
};

/// @tparam T  float or double.
template <class T>
class DeviceMultigrid {
 public:
  /// Makes the levels from the potential's scene and inertia.
  /// @throws Error (resources) if the device has too little memory.
  explicit DeviceMultigrid(DevicePotential& potential);
  ~DeviceMultigrid();

  /// Allocates what an additional stiffness needs.
  /// @param mass  of the nodes [kg], (nodes), on the device, where add_inertia() will be called.
  void expect_stiffness(const double* mass = nullptr);
  /// Other inertia, as a stiffness of the free nodes: as Multigrid::scale_inertia, but pinned nodes
  /// count on no level. set_nodal_stiffness() and use_stiffness() make it count.
  /// @param more  a0 / dt^2 less that which the hierarchy was built with [1/s^2].
  void add_inertia(double more);
  /// As Multigrid::set_nodal_stiffness with the diagonals of the blocks; call expect_stiffness()
  /// before.
  void set_nodal_stiffness(const NodalStiffness& stiffness);
  /// Whether cycles use the additional stiffness.
  void use_stiffness(bool use);

  /// z = B r, one V-cycle from z = 0; r and z are (nodes, 3) on the device, r is 0 on pinned nodes.
  void apply(const T* r, T* z);
  /// apply() in three parts, for kernels that write r node by node to input(): start() makes the
  /// first pass over the finest level, cycle() all others.
  ResidualInput<T> input() const;
  void start();
  void cycle(T* z, const Companion<T>& companion = {});

 private:
  std::unique_ptr<DeviceMultigridLevels<T>> levels_;
};

/// Stencils of a level, for tests.
template <class T>
struct LevelRows {
  int64_t distinct = 0;    ///< rows, including that of slots without a node
  std::vector<T> by_node;  ///< (nodes, kRow) of stencil_bricks.hpp
};

/// Stencils of the levels of make_hierarchy (multigrid_grid.cuh), the finest level first.
template <class T>
std::vector<LevelRows<T>> hierarchy_rows(DevicePotential& potential, int hash_bits = 64);

}  // namespace elastogen::cuda
