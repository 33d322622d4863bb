// SPDX-License-Identifier: Apache-2.0
// What dependent nodes add to the diagonals of the levels (held_diagonal.hpp) while these are
// made (multigrid_grid.cu): [N/m], (slots, 3); empty where no node is dependent.

#pragma once

#include "network/precondition/stencil_rows.cuh"

namespace elastogen::cuda {

/// That of the nodes of the finest level, (3 nodes), by slot.
inline DeviceArray<double> folded_by_slot(const std::vector<double>& of_nodes,
                                          const DeviceArray<int32_t>& slot_of, int64_t slots) {
  if (of_nodes.empty()) return {};
  DeviceArray<double> folded(3 * slots);
  const DeviceArray<double> given(of_nodes);
  const double* const from = given.data();
  const int32_t* const slot = slot_of.data();
  double* const to = folded.data();
  cuda::for_each(given.size(),
                 [=] __device__(int64_t k) { to[3 * int64_t(slot[k / 3]) + k % 3] = from[k]; });
  return folded;
}

/// P^T of that of the finer level at the free nodes of a coarser one, one thread for each slot.
inline DeviceArray<double> folded_of_coarser(const SlotTables& fine, const SlotTables& coarse,
                                             int64_t slots) {
  if (fine.folded == nullptr) return {};
  DeviceArray<double> folded(3 * slots);
  double* const to = folded.data();
  cuda::for_each(slots, [=] __device__(int64_t slot) {
    if (!coarse.is_free(slot)) return;
    const Place at(slot);
    const int32_t* around = coarse.links[slot / kSlots].fine;
    double sum[3] = {};
    for (int k = 0; k < 27; ++k) {
      const int dx = k % 3 - 1, dy = k / 3 % 3 - 1, dz = k / 9 - 1;
      const int64_t child = fine.slot_at(around, 2 * at.x + dx, 2 * at.y + dy, 2 * at.z + dz);
      if (child < 0 || !fine.has_node(child)) continue;
      const int odd = (dx != 0) + (dy != 0) + (dz != 0);
      for (int i = 0; i < 3; ++i) sum[i] += fine.folded[3 * child + i] / double(1 << odd);
    }
    for (int i = 0; i < 3; ++i) to[3 * slot + i] = sum[i];
  });
  return folded;
}

}  // namespace elastogen::cuda
