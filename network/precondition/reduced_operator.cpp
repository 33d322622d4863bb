// SPDX-License-Identifier: Apache-2.0
#include "network/precondition/reduced_operator.hpp"

#include <Eigen/Cholesky>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

using Reduced = Eigen::Matrix<double, kReducedSize, kReducedSize, Eigen::RowMajor>;
using ReducedVector = Eigen::Matrix<double, kReducedSize, 1>;

/// The entries of a reduced operator that couple a component with itself; the others 0.
Reduced within_components(const Reduced& A) {
  Reduced D = A;
  for (int a = 0; a < kReducedSize; ++a)
    for (int b = 0; b < kReducedSize; ++b)
      if (a % 3 != b % 3) D(a, b) = 0;
  return D;
}

}  // namespace

double known_share(const Scene& scene) {
  double poisson = 0;
  for (const Material& m : scene.materials) poisson = std::max(poisson, m.poisson);
  // a tenth less for each halving of 1 - 2 nu beyond nu = 0.49
  const double halvings = std::log2(0.02 / std::max(1 - 2 * poisson, 1e-3));
  return std::clamp(0.8 - 0.1 * halvings, 0.0, 0.8);
}

ReducedOperator::ReducedOperator(std::vector<double>&& at_rest, double share)
    : known(share), rest(std::move(at_rest)) {
  invert(rest);
}

/// Inverts A scaled to unit diagonal; the 1e-9 bounds the inverse where modes depend on each other.
void ReducedOperator::invert(const std::vector<double>& A) {
  const Eigen::Map<const Reduced> full(A.data());
  const ReducedVector scale = full.diagonal().array().max(1e-300).sqrt().inverse().matrix();
  Reduced scaled = scale.asDiagonal() * (full + full.transpose()) * scale.asDiagonal() / 2;
  scaled.diagonal().array() += 1e-9;
  const auto take_inverse = [&](const Reduced& of) {
    const Reduced result = of.llt().solve(Reduced::Identity());
    return Reduced(scale.asDiagonal() * (result + result.transpose()) * scale.asDiagonal() / 2);
  };
  const Reduced whole = take_inverse(scaled);
  const Reduced more = whole - known * take_inverse(within_components(scaled));
  inverse.assign(whole.data(), whole.data() + whole.size());
  correction.assign(more.data(), more.data() + more.size());
}

/// Power method on A_r^-1 D_r, which is symmetric in the product with D_r.
double ReducedOperator::softness() const {
  constexpr int kSteps = 50;
  const Eigen::Map<const Reduced> A(rest.data()), inverted(inverse.data());
  const Reduced D = within_components(A);
  ReducedVector x = A.diagonal().array().max(1e-300).sqrt().inverse().matrix();
  for (int k = 0; k < kReducedSize; ++k)
    x(k) *= 1 + 0.1 * (k % 7);  // not orthogonal to any direction
  double value = 1;
  for (int step = 0; step < kSteps; ++step) {
    const ReducedVector Dx = D * x, y = inverted * Dx;
    value = y.dot(Dx) / x.dot(Dx);
    x = y / y.norm();
  }
  return std::max(1.0, value);
}

}  // namespace elastogen
