// SPDX-License-Identifier: Apache-2.0
// Nine doubles as a deformation gradient: F = U diag(s) V^T, and every law finite at it.

#include "core/principal.hpp"
#include "tests/fuzz/harness.hpp"
#include "tests/support/laws.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>

namespace elastogen {
namespace {

constexpr double kLargest = 1e20;  ///< of an entry: energies go with J^4 and must not overflow
constexpr double kPoisson[] = {0, 0.3, 0.45, 0.499};

void require_finite(const double* values, int count) {
  for (int k = 0; k < count; ++k) fuzz::require(std::isfinite(values[k]), "every number is finite");
}

void check_svd(const Mat3<double>& F, const Svd3<double>& svd) {
  double size = 0;
  for (const double x : F.m) size = std::max(size, std::abs(x));
  const double tolerance = 1e-12 * size + 1e-300;  // numbers below have fewer digits
  require_finite(svd.sigma, 3);
  const Mat3<double> again = first_piola(svd, svd.sigma);  // U diag(sigma) V^T
  for (int k = 0; k < 9; ++k)
    fuzz::require(std::abs(again.m[k] - F.m[k]) <= tolerance, "F = U diag(sigma) V^T");
  for (const Mat3<double>& Q : {svd.U, svd.V}) {
    const Mat3<double> one = transposed_times(Q, Q);
    for (int k = 0; k < 9; ++k)
      fuzz::require(std::abs(one.m[k] - (k % 4 == 0)) <= 1e-12, "U and V are orthogonal");
    fuzz::require(determinant(Q) > 0, "U and V are rotations");
  }
  fuzz::require(svd.sigma[0] >= svd.sigma[1] - tolerance &&
                    svd.sigma[1] >= std::abs(svd.sigma[2]) - tolerance,
                "stretches are sorted");
}

void check_law(Law law, double poisson, const Mat3<double>& F) {
  const test::Point<double> p = test::point(test::parameters<double>(law, 1e6, poisson), F);
  require_finite(&p.r.psi, 1);
  require_finite(p.r.t, 3);
  require_finite(p.r.H, 6);
  require_finite(p.P.m, 9);
  const PrincipalHessian<double> h = positive_part(p.hessian);
  require_finite(h.A.m, 6);
  require_finite(h.twist, 3);
  require_finite(h.flip, 3);
}

}  // namespace
}  // namespace elastogen

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
  using namespace elastogen;
  Mat3<double> F;
  if (size < sizeof F.m) return 0;
  std::memcpy(F.m, data, sizeof F.m);
  for (const double x : F.m)
    if (!(std::abs(x) <= kLargest)) return 0;
  check_svd(F, svd3(F));
  const double poisson = kPoisson[size > sizeof F.m ? data[sizeof F.m] % 4 : 0];
  for (const Law law : test::kLaws) check_law(law, poisson, F);
  return 0;
}
