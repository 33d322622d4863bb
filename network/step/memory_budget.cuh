// SPDX-License-Identifier: Apache-2.0
// Things are made on the device only if its memory suffices for them to the end.

#pragma once

#include "core/cuda/array.cuh"

#include <algorithm>

namespace elastogen::cuda {

inline size_t free_bytes() {
  size_t free = 0, total = 0;
  check(cudaMemGetInfo(&free, &total));
  return free;
}

inline int64_t mebibytes(size_t bytes) {
  return int64_t((bytes >> 20) + 1);
}

/// Bytes of the device that recipe.make() needs: the most that it uses while it runs or, where that
/// is more, the bytes of its result and those that the result allocates later.
template <class Recipe>
size_t bytes_of(const Recipe& recipe) {
  const MemoryCount count;
  const auto counted = recipe.make();
  return std::max(count.most(), count.bytes() + counted->later_bytes());
}

/// The result of recipe.make(). If memory does not suffice, make() runs again, only to count bytes.
/// @throws Error (resources) that says how many bytes are needed and how many are free.
template <class Recipe>
auto within_budget(const Recipe& recipe) {
  const size_t available = free_bytes();
  try {
    const PinnedUpload upload;
    auto made = recipe.make();
    if (made->later_bytes() <= free_bytes()) return made;
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kResources) throw;
    if (bytes_of(recipe) <= available) throw;  // memory was not the reason
  }
  throw Error(concat("the scene needs ", mebibytes(bytes_of(recipe)),
                     " MiB of the card's memory, of which ", mebibytes(available),
                     " are free: a coarser grid (--voxels) needs less, and --device cpu none"),
              ErrorKind::kResources);
}

}  // namespace elastogen::cuda
