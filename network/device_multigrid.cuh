// SPDX-License-Identifier: Apache-2.0
// The V-cycle of network/multigrid.hpp on the device: the numbers of a finished hierarchy, copied
// once, and the same cycle, launched without waiting for the device: level by level where a level
// fills the card, the small ones together as one cluster of blocks (compute capability 9.0).

#pragma once

#include "network/multigrid.hpp"

#include <memory>

namespace elastogen::cuda {

template <class T>
struct DeviceMultigridLevels;

/// @tparam T  float or double.
template <class T>
class DeviceMultigrid {
 public:
  /// Takes the host's present nodal stiffness; later changes of the host have no effect.
  /// @throws Error (resources) where the device has no room.
  explicit DeviceMultigrid(const Multigrid<T>& host);
  ~DeviceMultigrid();

  /// z = B r, one V-cycle from z = 0; r and z are (nodes, 3) on the device, r is 0 on pinned nodes.
  void apply(const T* r, T* z);

 private:
  std::unique_ptr<DeviceMultigridLevels<T>> levels_;
};

}  // namespace elastogen::cuda
