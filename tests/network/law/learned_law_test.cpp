// SPDX-License-Identifier: Apache-2.0
// A net in the place of a law. A net whose weights are all 0 is the Hencky law: its strains are
// q = (H/omega)^(1/2) e. Put in the place of another law, it must give Hencky's numbers in its box.

#include "network/law/learned_law.hpp"

#include "core/strain_law.hpp"
#include "tests/network/law/mtl_support.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <utility>

namespace elastogen::test {
namespace {

constexpr double kLearnedYoung = 2e6;

LearnedLaw hencky_net(Law law, double nu, Evaluation evaluation) {
  const std::vector<float> zero(size_t(NeuralMtl::kParameters), 0.0f);
  return {zero, law, nu, "none", evaluation};
}

struct Errors {
  double stress = 0, tangent = 0;
};

/// Largest errors of a response relative to a law's, over stretches given by their logs.
Errors stress_errors(const LearnedLaw& net, const std::vector<double>& e, Law law) {
  const LawParameters<double> own = parameters<double>(net.law(), kLearnedYoung, net.poisson());
  const LawParameters<double> other = parameters<double>(law, kLearnedYoung, net.poisson());
  Errors worst;
  for (size_t k = 0; k < e.size() / 3; ++k) {
    double s[3], outside, t[3], H[6];
    for (size_t i = 0; i < 3; ++i) s[i] = std::exp(e[3 * k + i]);
    const Response<double> r = learned_response<true>(net, own, s, outside);
    const Response<double> exact = elastic_response<true>(other, s);
    for (int i = 0; i < 3; ++i) t[i] = r.t[i] - exact.t[i];
    for (int c = 0; c < 6; ++c) H[c] = r.H[c] - exact.H[c];
    const double rest = 1e-4 * (2 * own.mu + own.lambda);
    worst.stress = std::max(worst.stress, length(t, 3) / (length(exact.t, 3) + rest));
    worst.tangent = std::max(worst.tangent, length(H, 6) / length(exact.H, 6));
  }
  return worst;
}

TEST(LearnedLaw, IsThatOfTheNetInItsBox) {
  const std::vector<double> e = strains(1000, 500, 0.9, 0.69);
  for (const Law law : {Law::kNeoHookean, Law::kFixedCorotated})
    for (const double nu : {0.0, 0.3, 0.45}) {
      const Errors exact = stress_errors(hencky_net(law, nu, Evaluation::kNet), e, Law::kHencky);
      EXPECT_LT(exact.stress, 1e-9);
      EXPECT_LT(exact.tangent, 1e-12);
    }
}

TEST(LearnedLaw, ValuesAloneAreThoseOfTheJets) {
  const std::vector<double> e = strains(500, 50, 1.3, 1.3);
  const LearnedLaw net = hencky_net(Law::kNeoHookean, 0.3, Evaluation::kNet);
  std::vector<LogJet> jets(500);
  std::vector<double> psi(500, 7.0);
  net.difference<false>(e.data(), 500, jets.data());
  net.difference(e.data(), 500, psi.data());
  int beyond = 0;
  for (size_t k = 0; k < 500; ++k) {
    EXPECT_NEAR(psi[k], jets[k].psi, 1e-14);
    beyond += psi[k] == 0;
  }
  EXPECT_GT(beyond, 0);
  EXPECT_LT(beyond, 400);
}

TEST(LearnedLaw, TableAddsLittleEvenWhereTheNetIsFarFromItsLaw) {
  // well inside the box; at its edge the table must turn within two cells, tested by fits
  const std::vector<double> e = strains(1000, 500, 0.6, 0.5);
  const Errors found =
      stress_errors(hencky_net(Law::kNeoHookean, 0.3, Evaluation::kTable), e, Law::kHencky);
  EXPECT_LT(found.stress, 5e-3);
  EXPECT_LT(found.tangent, 2e-2);
  const Errors none =
      stress_errors(hencky_net(Law::kHencky, 0.3, Evaluation::kTable), e, Law::kHencky);
  EXPECT_LT(none.stress, 1e-12);
}

TEST(LearnedLaw, IsTheLawFarAwayAndSaysSo) {
  const LearnedLaw net = hencky_net(Law::kNeoHookean, 0.3, Evaluation::kNet);
  const LawParameters<double> p = parameters<double>(Law::kNeoHookean, kLearnedYoung, 0.3);
  const double far[][3] = {{3.6, 1, 1}, {1.2, 1.1, 0.1}, {1, 1, -0.5}, {2.8, 2.8, 0.9}, {0, 0, 0}};
  for (const auto& s : far) {
    double outside = 0;
    const Response<double> r = learned_response<true>(net, p, s, outside);
    const Response<double> law = elastic_response<true>(p, s);
    EXPECT_EQ(outside, 1);
    EXPECT_EQ(r.psi, law.psi);
    for (int c = 0; c < 6; ++c) EXPECT_EQ(r.H[c], law.H[c]);
  }
  const double near[][3] = {{1, 1, 1}, {2.4, 0.7, 0.9}, {1.2, 0.42, 1.3}};
  for (const auto& s : near) {
    double outside = 1;
    learned_response<false>(net, p, s, outside);
    EXPECT_EQ(outside, 0);
  }
}

TEST(LearnedLaw, EndsAtTheLimitOfGentsLaw) {
  // I1 - 3 in uniaxial tension: x^2 + 2/x - 3 = 1.8 at 1.9365, 3 at 2.2691
  const Law law = Law::gent(2);
  const LearnedLaw net = hencky_net(law, 0.3, Evaluation::kNet);
  const LawParameters<double> gent = parameters<double>(law, 1, 0.3),
                              hencky = parameters<double>(Law::kHencky, 1, 0.3);
  for (const double stretch : {0.6, 1.5, 1.93, 1.95, 2.1, 2.26, 2.28}) {
    const double across = 1 / std::sqrt(stretch), s[3] = {stretch, across, across};
    double outside = -1;
    const Response<double> r = learned_response<false>(net, gent, s, outside),
                           inner = elastic_response<false>(hencky, s),
                           outer = elastic_response<false>(gent, s);
    EXPECT_EQ(outside, stretch > 1.9365 ? 1 : 0) << stretch;
    if (stretch < 1.9365) {
      EXPECT_NEAR(r.psi, inner.psi, 1e-12);
    } else if (stretch > 2.2691) {
      EXPECT_EQ(r.psi, outer.psi);
    } else {
      EXPECT_GT(r.psi, inner.psi);
      EXPECT_LT(r.psi, outer.psi);
    }
  }
}

TEST(LearnedLaw, DerivativesAreThoseOfTheEnergyAcrossTheBorder) {
  const std::pair<Evaluation, Law> rows[] = {{Evaluation::kNet, Law::kNeoHookean},
                                             {Evaluation::kTable, Law::kNeoHookean},
                                             {Evaluation::kNet, Law::gent(3)},
                                             {Evaluation::kTable, Law::gent(8)}};
  for (const auto& [evaluation, law] : rows) {
    const LearnedLaw net = hencky_net(law, 0.4, evaluation);
    const LawParameters<double> p = parameters<double>(law, 1, 0.4);
    // strains inside the box, across its border and beyond
    const std::vector<double> e = strains(300, 50, 1.3, 1.3);
    for (size_t k = 0; k < 300; ++k)
      for (size_t m = 0; m < 3; ++m) {
        constexpr double kStep = 1e-6;
        double s[3], up[3], down[3], outside;
        for (size_t i = 0; i < 3; ++i) s[i] = up[i] = down[i] = std::exp(e[3 * k + i]);
        // central differences along each stretch
        up[m] += kStep, down[m] -= kStep;
        const Response<double> here = learned_response<true>(net, p, s, outside);
        const Response<double> a = learned_response<false>(net, p, up, outside),
                               b = learned_response<false>(net, p, down, outside);
        const double scale = 1 + length(here.H, 6);
        EXPECT_NEAR((a.psi - b.psi) / (2 * kStep), here.t[m], 1e-8 * scale);
        EXPECT_NEAR((a.t[m] - b.t[m]) / (2 * kStep), here.H[m], 1e-4 * scale);
        const size_t n = (m + 1) % 3;
        EXPECT_NEAR((a.t[n] - b.t[n]) / (2 * kStep), here.H[3 + m], 1e-4 * scale);
      }
  }
}

/// Energy and stress of a net and its law through Green's strain, as voxels take them.
bool by_strain(const LearnedLaw& net, const LawParameters<double>& law, const Mat3<double>& H,
               StrainResponse<double>& r, double& outside) {
  const auto difference = [&](const double e[3]) { return learned_difference(net, e); };
  const auto add = [&](const Symmetric3<double>& E, double& psi, Symmetric3<double>& S) {
    add_difference(law, E, difference, psi, S, outside);
  };
  return strain_response(law, H, add, r);
}

/// Hencky's net in the place of other laws: within their boxes, across the border, at rest and
/// close to it, with equal stretches.
TEST(LearnedLaw, SaysTheSameThroughStrainsAsThroughStretches) {
  Random random(7);
  std::vector<double> e = strains(600, 200, 1.2, 1.2);
  for (const double equal : {0.0, 1e-9, 0.3, -0.5}) e.insert(e.end(), {equal, equal, 0.1 * equal});
  for (const Law law : {Law::kNeoHookean, Law::kStvk, Law::kStableNeoHookean})
    for (const Evaluation evaluation : {Evaluation::kTable, Evaluation::kNet}) {
      const LearnedLaw net = hencky_net(law, 0.4, evaluation);
      const LawParameters<double> p = parameters<double>(law, 1, 0.4);
      int compared = 0;
      for (size_t k = 0; k < e.size() / 3; ++k) {
        // F with these stretches, turned at random
        const Mat3<double> F =
            stretched(std::exp(e[3 * k]), std::exp(e[3 * k + 1]), std::exp(e[3 * k + 2]), random);
        Mat3<double> H = F;
        for (int i = 0; i < 3; ++i) H(i, i) -= 1;
        StrainResponse<double> found;
        double outside = -1, also_outside = -1;
        if (!by_strain(net, p, H, found, outside)) continue;
        ++compared;
        // the response by singular values
        const Svd3<double> svd = svd3(F);
        const Response<double> r = learned_response<false>(net, p, svd.sigma, also_outside);
        const Mat3<double> P = first_piola(svd, r.t);
        ASSERT_EQ(outside, also_outside);
        ASSERT_NEAR(found.psi, r.psi, 1e-12 * (1 + std::abs(r.psi)));
        ASSERT_LT(distance(found.P, P), 1e-11 * (1 + norm(P)));
      }
      EXPECT_GT(compared, 300);
    }
}

TEST(LearnedLaw, StressThroughStrainsIsTheDerivativeOfTheEnergy) {
  constexpr double d = 1e-6;
  Random random(8);
  const LearnedLaw net = hencky_net(Law::kNeoHookean, 0.4, Evaluation::kTable);
  const LawParameters<double> p = parameters<double>(Law::kNeoHookean, 1, 0.4);
  for (int k = 0; k < 200; ++k) {
    Mat3<double> H = k % 2 ? stretched(1.5, 1.1, 0.6, random) : stretched(1.01, 1.01, 0.98, random);
    for (int i = 0; i < 3; ++i) H(i, i) -= 1;
    StrainResponse<double> at, up, down;
    double outside;
    ASSERT_TRUE(by_strain(net, p, H, at, outside));
    for (int m = 0; m < 9; ++m) {
      Mat3<double> above = H, below = H;
      above.m[m] += d, below.m[m] -= d;
      ASSERT_TRUE(by_strain(net, p, above, up, outside) && by_strain(net, p, below, down, outside));
      ASSERT_NEAR(at.P.m[m], (up.psi - down.psi) / (2 * d), 1e-8);
    }
  }
}

TEST(LearnedLaw, GivesTheSameInPacks) {
  const LearnedLaw net = hencky_net(Law::kNeoHookean, 0.3, Evaluation::kTable);
  const LawParameters<double> p = parameters<double>(Law::kNeoHookean, kLearnedYoung, 0.3);
  Pack<double> s[3], outside;
  const std::vector<double> e = strains(kLanes, 2, 1.2, 1);
  for (int l = 0; l < kLanes; ++l)
    for (int i = 0; i < 3; ++i) s[i][l] = std::exp(e[size_t(3 * l + i)]);
  s[1][5] = std::numeric_limits<double>::quiet_NaN();
  s[2][6] = -0.3;
  const Response<Pack<double>> r = learned_response<true>(net, p, s, outside);
  for (int l = 0; l < kLanes; ++l) {
    if (l == 5) continue;
    const double one[3] = {s[0][l], s[1][l], s[2][l]};
    double out;
    const Response<double> exact = learned_response<true>(net, p, one, out);
    EXPECT_EQ(outside[l], out);
    EXPECT_NEAR(r.psi[l], exact.psi, 1e-12 * (kLearnedYoung + exact.psi));
    EXPECT_NEAR(r.H[4][l], exact.H[4], 1e-12 * (kLearnedYoung + std::abs(exact.H[4])));
  }
  EXPECT_FALSE(std::isfinite(r.psi[5]));
}

}  // namespace
}  // namespace elastogen::test
