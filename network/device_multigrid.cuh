// SPDX-License-Identifier: Apache-2.0
// The V-cycle of network/multigrid.hpp on the device: the numbers of a finished hierarchy, copied
// once, and the same cycle, launched level by level without waiting for the device.

#pragma once

#include "network/multigrid.hpp"

#include <memory>
#include <vector>

namespace elastogen::cuda {

template <class T>
struct DeviceMultigridLevel;

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
  void cycle(size_t l, T* z);
  std::vector<std::unique_ptr<DeviceMultigridLevel<T>>> levels_;
  T scale_;  // 1 / unit
};

}  // namespace elastogen::cuda
