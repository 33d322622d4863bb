// SPDX-License-Identifier: Apache-2.0
// Measurements of the CUDA device. In builds without CUDA every function throws Error (device).

#pragma once

#include "core/scene.hpp"

#include <string>
#include <vector>

namespace elastogen::bench {

/// A kernel's time and the bytes that must move at least once.
struct KernelRow {
  std::string name;
  double bytes = 0, ms = 0;
};

struct CardCeilings {
  double copy = 0;                         ///< bytes read and written a second
  double float_rate = 0, double_rate = 0;  ///< fused multiply-adds count twice [FLOP/s]
  double launch_us = 0;                    ///< one kernel of many in a row [us]
  double graph_node_us = 0;                ///< one kernel inside a graph [us]
  double sync_us = 0;                      ///< one kernel and the wait for it [us]
  double fetch_us = 0;                     ///< a copy of 64 bytes to the host [us]
  int64_t memory_bytes = 0;
  int multiprocessors = 0;
};

/// Bytes read and written a second by a copy of 2 GB, or of an eighth of the card.
double card_copy_rate();

CardCeilings card_ceilings();

/// Memory of the card that all programs together use [bytes].
int64_t card_memory_used();

/// The kernels of a step of the scene.
std::vector<KernelRow> card_kernels(const Scene& scene);

}  // namespace elastogen::bench
