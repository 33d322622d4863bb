// SPDX-License-Identifier: Apache-2.0
// The encoder of encoder.hpp on the device, used beside multigrid. The device makes modes
// and operators, the host the corrections. apply() launches three kernels; all sums have a fixed
// order.

#pragma once

#include "core/cuda/array.cuh"
#include "network/contact/contact_device.hpp"
#include "network/precondition/encoder_modes.cuh"
#include "network/precondition/reduced_operator.hpp"

namespace elastogen::cuda {

__device__ inline float mode_value(__half mode) {
  return __half2float(mode);
}
__device__ inline double mode_value(double mode) {
  return mode;
}

/// A range of entries in the list of all pieces' nodes; all of them belong to one piece.
struct EncoderChunk {
  int32_t piece, begin, end;
};

/// A node with additional stiffness: its index among such nodes, and in the list of all pieces'
/// nodes.
struct StiffEntry {
  int32_t stiff, node;
};

/// @tparam T  float or double.
template <class T>
class DeviceEncoder {
 public:
  /// Makes modes and operators at rest of a potential, which must have its inertia.
  /// @param pieces  nodes of encoder_pieces.
  /// @throws Error (resources) if the device has too little memory.
  DeviceEncoder(DevicePotential& potential, const std::vector<std::vector<int32_t>>& pieces);

  /// As Encoder::softness. While memory is only counted there are no operators: it is infinite.
  double softness() const;

  /// Allocates what an additional stiffness of these nodes needs, in this order; `pieces` are those
  /// of the constructor.
  void expect_stiffness(const std::vector<std::vector<int32_t>>& pieces,
                        const std::vector<int32_t>& nodes);
  /// Allocates what other inertia needs; the potential has that of the constructor. Call
  /// expect_stiffness() before.
  void expect_inertia(DevicePotential& potential);
  /// As Encoder::set_inertia; set_nodal_stiffness() and use_stiffness() make it count.
  /// @param ratio  to the inertia of the constructor.
  void scale_inertia(double ratio);
  /// As Encoder::set_nodal_stiffness; call expect_stiffness() before.
  void set_nodal_stiffness(const NodalStiffness& stiffness);
  /// Whether apply() uses the additional stiffness.
  void use_stiffness(bool use) { use_stiffness_ = use; }

  /// z = B (A_r^-1 - s D_r^-1) B^T r on the nodes of the pieces; (nodes, 3), on the device.
  void apply(const T* r, T* z, cudaStream_t stream);

 private:
  int64_t piece_count() const { return chunk_begin_.size() - 1; }

  PieceModesOnDevice<T> modes_;
  std::vector<ReducedOperator> operators_;  // of the pieces
  DeviceArray<double>
      corrections_;  // A_r^-1 - s D_r^-1, (pieces, 3 kModes, 3 kModes), column-major
  DeviceArray<EncoderChunk> chunks_;  // in the order of the pieces
  DeviceArray<int32_t> chunk_begin_;  // first chunk of each piece, (pieces + 1)
  DeviceArray<T> partial_;            // B^T r of each chunk, (chunks, 3 kModes)
  DeviceArray<double> solution_;      // corrections times B^T r, (pieces, 3 kModes)

  // of an additional stiffness, after expect_stiffness()
  bool use_stiffness_ = false;
  DeviceArray<double> rest_;                // A_r without it, (pieces, 3 kModes, 3 kModes)
  DeviceArray<StiffEntry> stiff_;           // piece by piece
  DeviceArray<EncoderChunk> stiff_chunks_;  // of stiff_
  DeviceArray<int32_t> stiff_begin_;        // first chunk of each piece, (pieces + 1)
  DeviceArray<double> products_;            // of the chunks, then of the pieces, kProducts each
  DeviceArray<int32_t> touched_;            // chunks whose products are not all 0
  DeviceArray<double> stiff_corrections_;   // like corrections_
  // of other inertia, after expect_inertia(): A_r as built, and the part of the inertia in it
  DeviceArray<double> built_, inertia_;
};

}  // namespace elastogen::cuda
