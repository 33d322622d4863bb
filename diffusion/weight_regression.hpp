// SPDX-License-Identifier: Apache-2.0
// Codes of materials by kernel regression on their features, with the Matern-5/2 kernel
//
//   k(x, y) = (1 + sqrt5 r + 5/3 r^2) exp(-sqrt5 r),   r^2 = sum_k ((x - y)_k / l_k)^2
//
// code(x) = sum_n k(x, x_n) a_n, where K a = the known codes. The fits are exact to about 1e-6, so
// K gets nearly no ridge: 1e-10 already costs accuracy. In double, because large terms of both
// signs cancel.

#pragma once

#include "core/array.hpp"
#include "core/tensor_file.hpp"
#include "diffusion/material_features.hpp"

#include <vector>

namespace elastogen {

class WeightRegression {
 public:
  /// Solves for the coefficients.
  /// @param features  (n, 15), n > 0; rounded to floats, as files have them.
  /// @param codes     (n, components).
  /// @param lengths   l, (15), positive; empty: the lengths by which three quarters of up to 1024
  ///                  codes predict the other quarter best, in the mean logarithm of the error.
  /// @throws Error (usage) for other sizes.
  WeightRegression(In<double> features, In<double> codes, std::vector<double> lengths = {});

  /// Reads the tensors "regression.*" of a file. @throws Error (asset) if any is missing.
  WeightRegression(const TensorFile& file, int components);
  /// Adds these tensors to a file.
  void write(TensorFile& file) const;

  int64_t count() const { return features_.rows(); }
  const std::vector<double>& lengths() const { return lengths_; }

  /// The code at features x, (15).
  std::vector<double> code(const double* x) const;
  /// r^2 between x and each known material, (n).
  std::vector<double> distances(const double* x) const;

 private:
  Array<double> features_, coefficients_;  // (n, 15), (n, components)
  std::vector<double> lengths_;
};

}  // namespace elastogen
