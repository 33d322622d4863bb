// SPDX-License-Identifier: Apache-2.0
// RNN-2's pass on the device (preconditioner.hpp), B = R (V-cycle + encoder) R^T, in three
// parts, so that the kernels that make its argument and read its result need no pass of their own.

#pragma once

#include "core/cuda/branch.cuh"
#include "core/cuda/graph.cuh"
#include "network/potential/incremental_potential_device.hpp"
#include "network/precondition/encoder.cuh"
#include "network/precondition/multigrid.cuh"
#include "network/precondition/preconditioner.hpp"
#include "network/precondition/stencil.cuh"

#include <optional>

namespace elastogen::cuda {

/// The result of a cycle, which is still in the frames of the nodes.
struct UnturnedResult {
  const Quaternion<float>* rotation;
  const float* values;
  const uint8_t* pinned;
  float scale = 1;

  /// B q at a node, 0 if it is pinned or follows others.
  template <class T>
  __device__ void at(int64_t n, T v[3]) const {
    const Mat3<float> R = rotation_matrix(rotation[n]);
    const float* w = values + 3 * n;
    for (int i = 0; i < 3; ++i)
      v[i] = pinned[n] ? T(0) : T(scale * (R(i, 0) * w[0] + R(i, 1) * w[1] + R(i, 2) * w[2]));
  }
};

class DevicePreconditioner {
 public:
  /// The potential must outlive it, and have the scheme that will be used or, where the scene's
  /// steps have stages, the first one of them.
  DevicePreconditioner(DevicePotential& potential, const EncoderChoice& choice);

  /// Freezes the contact stiffness of the potential at u, and uses it from then on.
  /// @param touching  false where the contact energy at u is known to be 0.
  void update_contact(const double* u, bool touching) {
    if (DeviceContact* contact = potential_.contact()) contact->linearise(u, touching);
    take_contact();
  }

  /// Uses the contact stiffness that is frozen, as Preconditioner::update_contact.
  void take_contact();
  /// As Preconditioner::update_inertia, where the scene's steps have stages.
  void update_inertia(const StepScheme& scheme);

  /// Writes R^T q to the input of the cycle; read(n, v) gives the values q of a node.
  template <class Read>
  void turn(const Read& read) {
    const Quaternion<float>* rotation = potential_.nodal_rotation();
    const ResidualInput<float> input = multigrid_.input();
    float* turned = turned_.data();
    cuda::for_each(
        potential_.nodes(),
        [=] __device__(int64_t n) {
          const Mat3<float> R = rotation_matrix(rotation[n]);
          float v[3];
          read(n, v);
          float r[3];
          for (int i = 0; i < 3; ++i) r[i] = R(0, i) * v[0] + R(1, i) * v[1] + R(2, i) * v[2];
          if (turned != nullptr)
            for (int i = 0; i < 3; ++i) turned[3 * n + i] = r[i];
          input.set(n, r);
        },
        {}, input.finest.bricks <= kFewBlocks);
  }

  /// V-cycle and encoder on the input that turn() has written.
  void cycle();

  UnturnedResult result() const {
    return {potential_.nodal_rotation(), z_.data(), potential_.pinned(), scale_};
  }

  /// Whether cycles use what was added to the operators that they were built with.
  bool has_added() const { return in_contact_ || other_inertia_; }

 private:
  void use_added();
  void add(const NodalStiffness& stiffness);

  DevicePotential& potential_;
  DeviceMultigrid<float> multigrid_;
  std::optional<DeviceEncoder<float>> encoder_;
  DeviceBranch branch_;  // the encoder runs on it beside the coarse levels
  DeviceArray<float> z_;
  DeviceArray<double> share_;            // scale_, of the stiffness of contact
  DeviceArray<float> turned_, encoded_;  // input and output of the encoder
  DeviceGraph graph_, added_graph_, update_graph_;
  double built_with_, used_;  // a0 / dt^2 [1/s^2]
  float scale_ = 1;           // of the inverse
  bool in_contact_ = false, other_inertia_ = false;
};

}  // namespace elastogen::cuda
