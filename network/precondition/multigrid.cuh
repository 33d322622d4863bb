// SPDX-License-Identifier: Apache-2.0
// The V-cycle of network/precondition/multigrid.hpp on the device: levels that are made there
// (multigrid_grid.cuh), and the same cycle, launched without waiting for the device: level by
// level where a level fills the card, the small ones together as one cluster of blocks (compute
// capability 9.0).

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

/// What goes on beside the coarser levels of a cycle, which leave most of the card idle.
template <class T>
struct Companion {
  std::function<void()> begin;  ///< its launches; called once the finest level has its residual
  std::function<void()> end;    ///< what is launched next waits for them
  const T* result = nullptr;    ///< what they leave by node, (nodes, 3): z gets it too
};

/// @tparam T  float or double.
template <class T>
class DeviceMultigrid {
 public:
  /// Of the potential's scene and inertia.
  /// @throws Error (resources) where the device has no room.
  explicit DeviceMultigrid(DevicePotential& potential);
  ~DeviceMultigrid();

  /// Makes room for a further stiffness.
  void expect_stiffness();
  /// As Multigrid::set_nodal_stiffness with the diagonals of the blocks; only once it is expected.
  void set_nodal_stiffness(const NodalStiffness& stiffness);
  /// Whether cycles take it into account.
  void use_stiffness(bool use);

  /// z = B r, one V-cycle from z = 0; r and z are (nodes, 3) on the device, r is 0 on pinned nodes.
  void apply(const T* r, T* z);
  /// The same in parts, for kernels that put r there node by node: the first pass over it, then all
  /// that comes behind.
  ResidualInput<T> input() const;
  void start();
  void cycle(T* z, const Companion<T>& companion = {});

 private:
  std::unique_ptr<DeviceMultigridLevels<T>> levels_;
};

/// Stencils of a level, for tests.
template <class T>
struct LevelRows {
  int64_t distinct = 0;    ///< rows, with that of no node
  std::vector<T> by_node;  ///< (nodes, kRow) of stencil_bricks.hpp
};

/// Those that make_hierarchy makes (multigrid_grid.cuh), the finest level first.
template <class T>
std::vector<LevelRows<T>> hierarchy_rows(DevicePotential& potential, int hash_bits = 64);

}  // namespace elastogen::cuda
