// SPDX-License-Identifier: Apache-2.0
// A voxel's data, and its deformation gradient from pattern sums of the corners (core/hex8.hpp).

#pragma once

#include "core/hex8.hpp"
#include "core/mat3.hpp"
#include "core/scene.hpp"
#include "network/law/learned_law.hpp"

namespace elastogen {

/// Data of a voxel besides its displacement.
template <class T>
struct VoxelData {
  LawParameters<Scalar<T>> law;
  const LearnedLaw* learned = nullptr;  ///< null: the law itself
  Scalar<T> h;                          ///< edge [m]
  Hourglass hourglass = Hourglass::kFull;
  T phi;   ///< fill
  T c[4];  ///< variance weights [Pa]
  T M[7];  ///< moments of the fill; unused where the voxel is full
  T R[9];  ///< rotation at the start of the step
};

/// H = du/dX, the mean over the fill, from pattern sums.
template <bool kBorder, class T>
ELASTOGEN_HD inline Mat3<T> displacement_gradient(const VoxelData<T>& v, const T g[3][8]) {
  const Scalar<T> scale = 1 / (4 * v.h);
  Mat3<T> H;
  for (int i = 0; i < 3; ++i) {
    T d[3];
    hex8::gradient<kBorder>(g[i], v.M, d);
    for (int j = 0; j < 3; ++j) H(i, j) = d[j] * scale;
  }
  return H;
}

template <bool kBorder, class T>
ELASTOGEN_HD inline Mat3<T> deformation_gradient(const VoxelData<T>& v, const T g[3][8]) {
  return plus_identity(displacement_gradient<kBorder>(v, g));
}

}  // namespace elastogen
