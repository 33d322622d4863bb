// SPDX-License-Identifier: Apache-2.0
// What is made on the device is made where it has room for it to the end, or not at all.

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

/// What recipe.make() takes on the device, and what that will take later, or where it takes more on
/// its way, that.
template <class Recipe>
size_t bytes_of(const Recipe& recipe) {
  const RoomCount count;
  const auto counted = recipe.make();
  return std::max(count.most(), count.bytes() + counted->later_bytes());
}

/// What recipe.make() gives; it is made twice where there is no room, the second time to count.
/// @throws Error (resources) with what it needs and what is there.
template <class Recipe>
auto within_budget(const Recipe& recipe) {
  const size_t room = free_bytes();
  try {
    const PinnedUpload upload;
    auto made = recipe.make();
    if (made->later_bytes() <= free_bytes()) return made;
  } catch (const Error& error) {
    if (error.kind() != ErrorKind::kResources) throw;
    if (bytes_of(recipe) <= room) throw;  // it was not for want of room
  }
  throw Error(concat("the scene needs ", mebibytes(bytes_of(recipe)),
                     " MiB of the card's memory, of which ", mebibytes(room),
                     " are free: a coarser grid (--voxels) needs less, and --device cpu none"),
              ErrorKind::kResources);
}

}  // namespace elastogen::cuda
