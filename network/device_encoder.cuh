// SPDX-License-Identifier: Apache-2.0
// The encoder of network/encoder.hpp on the device: modes and inverses of a finished one, copied
// once, and the same map in three launches, all sums in a fixed order.

#pragma once

#include "core/device_array.cuh"
#include "network/encoder.hpp"

namespace elastogen::cuda {

/// Neighbouring entries of the list of all pieces' nodes, of one piece.
struct EncoderChunk {
  int32_t piece, begin, end;
};

/// @tparam T  float or double.
template <class T>
class DeviceEncoder {
 public:
  /// Takes the host's present inverses; later changes of the host have no effect.
  /// @throws Error (resources) where the device has no room.
  explicit DeviceEncoder(const Encoder<T>& host);

  /// z += B A_r^-1 B^T r; (nodes, 3), on the device.
  void add(const T* r, T* z);

 private:
  int64_t piece_count() const { return chunk_begin_.size() - 1; }

  DeviceArray<int32_t> nodes_;        // of all pieces, one after the other
  DeviceArray<T> modes_;              // (entries of nodes_, kModes)
  DeviceArray<double> inverses_;      // (pieces, 3 kModes, 3 kModes), column-major
  DeviceArray<EncoderChunk> chunks_;  // in the order of the pieces
  DeviceArray<int32_t> chunk_begin_;  // first chunk of each piece, (pieces + 1)
  DeviceArray<T> partial_;            // B^T r of each chunk, (chunks, 3 kModes)
  DeviceArray<double> solution_;      // A_r^-1 B^T r, (pieces, 3 kModes)
};

}  // namespace elastogen::cuda
