// SPDX-License-Identifier: Apache-2.0
#include "core/constitutive.hpp"

#include "tests/support/eigenvalues.hpp"
#include "tests/support/laws.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

using test::Random;
using Matrix9 = Eigen::Matrix<double, 9, 9, Eigen::RowMajor>;

/// Sand in log strain e under pressure: shear stress up to c times it, with c growing with the
/// plastic strain q. No flow of volume, so dtau/de is not symmetric.
struct Sand {
  using Real = double;
  struct History {
    double q = 0;
  };
  double mu = 1, bulk = 2, friction = 0.1, hardening = 3;

  struct Strain {
    double trace, size, n[3];
  };
  static Strain strain(const double s[3]) {
    const double e[3] = {std::log(s[0]), std::log(s[1]), std::log(s[2])};
    Strain r{e[0] + e[1] + e[2], 0, {}};
    for (const double x : e) r.size += (x - r.trace / 3) * (x - r.trace / 3);
    r.size = std::sqrt(r.size);
    for (int i = 0; i < 3; ++i) r.n[i] = (e[i] - r.trace / 3) / r.size;
    return r;
  }
  /// The largest shear stress, and whether the point is beyond it.
  double limit(const Strain& e, const History& history) const {
    return -(friction + hardening * history.q) * bulk * e.trace;
  }
  bool yields(const Strain& e, const History& history) const {
    return 2 * mu * e.size > limit(e, history);
  }

  template <bool>
  NonsymmetricResponse<double> response(const double s[3], const History& history) const {
    const Strain e = strain(s);
    const double slope = -(friction + hardening * history.q) * bulk;
    const double shear = yields(e, history) ? limit(e, history) : 2 * mu * e.size;
    double tau[3];
    Mat3<double> D;
    for (int i = 0; i < 3; ++i) {
      tau[i] = bulk * e.trace + shear * e.n[i];
      for (int j = 0; j < 3; ++j) {
        const double P = (i == j) - 1.0 / 3;
        D(i, j) =
            bulk + (yields(e, history) ? slope * e.n[i] + shear / e.size * (P - e.n[i] * e.n[j])
                                       : 2 * mu * P);
      }
    }
    return from_log_strain(s, 0.0, tau, D);
  }

  void commit(double s[3], History& history) const {
    const Strain e = strain(s);
    if (!yields(e, history)) return;
    const double size = limit(e, history) / (2 * mu);
    for (int i = 0; i < 3; ++i) s[i] = std::exp(e.trace / 3 + size * e.n[i]);
    history.q += e.size - size;
  }
};

/// dP/dF by central differences.
template <class L>
Matrix9 differences(const L& law, const Mat3<double>& F, const typename L::History& history) {
  constexpr double kStep = 1e-6;
  Matrix9 A;
  for (int l = 0; l < 9; ++l) {
    Mat3<double> above = F, below = F;
    above.m[l] += kStep, below.m[l] -= kStep;
    const Mat3<double> Pa = piola_stress(law, above, history),
                       Pb = piola_stress(law, below, history);
    for (int k = 0; k < 9; ++k) A(k, l) = (Pa.m[k] - Pb.m[k]) / (2 * kStep);
  }
  return A;
}

template <class L>
Matrix9 gradient(const L& law, const Mat3<double>& F, TangentKind kind,
                 const typename L::History& history) {
  Matrix9 A;
  piola_gradient(law, F, kind, A.data(), history);
  return A;
}

TEST(Constitutive, TangentOfAnElasticLawIsTheSlopeOfItsStress) {
  Random random(1);
  for (const Law kind : test::kLaws) {
    const ElasticLaw<double> law = {test::parameters<double>(kind, 1, 0.3)};
    const Mat3<double> F = test::stretched(1.3, 1.1, 0.8, random);
    const Matrix9 A = gradient(law, F, TangentKind::kTrue, {});
    EXPECT_LT((A - differences(law, F, {})).norm(), 1e-8 * A.norm()) << law_name(kind);
    EXPECT_LT((A - A.transpose()).norm(), 1e-14 * A.norm()) << law_name(kind);
  }
}

TEST(Constitutive, StressOfAnElasticLawIsTheSlopeOfItsEnergyInFloatToo) {
  Random random(2);
  for (const Law kind : test::kLaws) {
    const ElasticLaw<double> law = {test::parameters<double>(kind, 1, 0.3)};
    const ElasticLaw<float> low = {test::parameters<float>(kind, 1, 0.3f)};
    const Mat3<double> F = test::stretched(1.3, 1.1, 0.8, random);
    const Mat3<double> P = piola_stress(law, F);
    const Mat3<float> Pf = piola_stress(low, test::cast<float>(F));
    for (int k = 0; k < 9; ++k) {
      constexpr double kStep = 1e-6;
      Mat3<double> above = F, below = F;
      above.m[k] += kStep, below.m[k] -= kStep;
      const double slope = (energy_density(law, above) - energy_density(law, below)) / (2 * kStep);
      EXPECT_NEAR(P.m[k], slope, 1e-9) << law_name(kind);
      EXPECT_NEAR(P.m[k], double(Pf.m[k]), 1e-5) << law_name(kind);
    }
  }
}

TEST(Constitutive, ProjectedTangentHasNoNegativeEigenvalue) {
  Random random(3);
  const ElasticLaw<double> law = {test::parameters<double>(Law::kStvk, 1, 0.3)};
  const Mat3<double> F = test::stretched(0.6, 0.5, 0.4, random);
  const Matrix9 A = gradient(law, F, TangentKind::kTrue, {});
  EXPECT_LT(test::eigenvalues(A)(0), -0.1);
  const Matrix9 positive = gradient(law, F, TangentKind::kProjected, {});
  EXPECT_LT((positive - test::clamped(A)).norm(), 1e-13 * A.norm());
}

/// Below and beyond yield, fresh and hardened; stretches apart, two equal, nearly equal.
TEST(Constitutive, TangentOfAPlasticLawIsTheSlopeOfItsStress) {
  Random random(4);
  const Sand sand;
  const double stretches[4][3] = {
      {0.95, 0.9, 0.7}, {0.9, 0.9, 0.7}, {0.9 + 1e-8, 0.9, 0.7}, {0.93, 0.92, 0.91}};
  int beyond = 0;
  for (const double q : {0.0, 0.02})
    for (const auto& s : stretches) {
      beyond += sand.yields(Sand::strain(s), {q});
      const Mat3<double> F = test::stretched(s[0], s[1], s[2], random);
      const Matrix9 A = gradient(sand, F, TangentKind::kTrue, {q});
      EXPECT_LT((A - differences(sand, F, {q})).norm(), 1e-7 * A.norm()) << s[0] << ' ' << q;
    }
  EXPECT_EQ(beyond, 6);
}

TEST(Constitutive, TangentOfAPlasticLawIsNotSymmetricUnlessProjected) {
  Random random(5);
  const Sand sand;
  const Mat3<double> F = test::stretched(0.95, 0.9, 0.7, random);
  const Matrix9 A = gradient(sand, F, TangentKind::kTrue, {});
  EXPECT_GT((A - A.transpose()).norm(), 0.05 * A.norm());
  const Matrix9 positive = gradient(sand, F, TangentKind::kProjected, {});
  EXPECT_LT((positive - test::clamped((A + A.transpose()) / 2)).norm(), 1e-13 * A.norm());
}

TEST(Constitutive, CommitLeavesTheStressAndAPointThatDoesNotYield) {
  Random random(6);
  const Sand sand{.hardening = 0};
  Mat3<double> F = test::stretched(0.95, 0.9, 0.7, random);
  Sand::History history;
  const Mat3<double> tau = times_transposed(piola_stress(sand, F, history), F);
  commit(sand, F, history);
  EXPECT_GT(history.q, 0.01);
  EXPECT_LT(test::distance(times_transposed(piola_stress(sand, F, history), F), tau), 1e-14);
  const Mat3<double> again = F;
  const double q = history.q;
  commit(sand, F, history);
  EXPECT_LT(test::distance(F, again), 1e-14);
  EXPECT_NEAR(history.q, q, 1e-15);
}

TEST(Constitutive, ElasticLawsHaveNoHistory) {
  Random random(7);
  const ElasticLaw<double> law = {test::parameters<double>(Law::kHencky, 1, 0.3)};
  Mat3<double> F = test::stretched(0.95, 0.9, 0.7, random);
  const Mat3<double> before = F;
  NoHistory history;
  commit(law, F, history);
  EXPECT_EQ(test::distance(F, before), 0);
}

}  // namespace
}  // namespace elastogen
