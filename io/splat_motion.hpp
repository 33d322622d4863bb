// SPDX-License-Identifier: Apache-2.0
// Turns and stretches Gaussian splats with the body: covariance F S F^T, and colours that turn with
// the rotation of F.
//
// Spherical harmonics are those of 3-D Gaussian splatting (Kerbl et al. 2023): real, with the
// Condon-Shortley phase, so that degree 1 is C1 (-y, z, -x).

#pragma once

#include "core/mat3.hpp"
#include "io/asset.hpp"

namespace elastogen {

/// Values of the harmonics of degrees 0 ... 3 in a unit direction; writes the first (degree + 1)^2.
void spherical_harmonics(int degree, const Vec3& direction, double* values);

/// Rotation of a quaternion w x y z of any length.
Mat3<double> rotation_matrix(const std::array<float, 4>& quaternion);

/// Moves splats frame by frame.
class SplatMotion {
 public:
  /// @param splats  the splats at rest; must outlive this.
  /// @throws Error if the degree is not 0 ... 3 or an array has the wrong length.
  explicit SplatMotion(const SplatCloud& splats);

  /// Turns the splats of the rest pose:
  ///
  ///     F = U diag(s) V^T,   s clamped to 1/3 ... 3,   S' = F S F^T,   colour'(R v) = colour(v),
  ///
  /// with R = U V^T. Scales and rotations are the principal axes of S', right-handed, in the order
  /// and with the signs that continue the frame before. Where F is exactly I a splat does not
  /// change.
  /// @param gradient  F at the splats, (splats, 9), finite.
  void turn(In<double> gradient);

  // filled by turn; the rest pose before the first call
  std::vector<std::array<float, 3>> scale;     ///< as SplatCloud
  std::vector<std::array<float, 4>> rotation;  ///< unit quaternions w x y z
  std::vector<float> harmonics;                ///< as SplatCloud
  int64_t clamped = 0;  ///< splats of this frame whose stretches were out of range or inverted

 private:
  bool turn_splat(size_t i, const Mat3<double>& F);
  void turn_colour(size_t i, const Mat3<double>& R);

  const SplatCloud& rest_;
  std::vector<Mat3<double>> axes_;  ///< axes of the frame before, relative to its rotation
  std::vector<double> fit_;         ///< maps values in the fixed directions to coefficients
};

}  // namespace elastogen
