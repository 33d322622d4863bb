// SPDX-License-Identifier: Apache-2.0
// The net's energy and its derivatives, against a plain evaluation of the formulas and against
// finite differences.

#include "network/law/neural_mtl.hpp"

#include "core/error.hpp"
#include "tests/network/law/mtl_support.hpp"

#include <gtest/gtest.h>

namespace elastogen::test {
namespace {

constexpr int kFirst[6] = {0, 1, 2, 0, 1, 2}, kSecond[6] = {0, 1, 2, 1, 2, 0};

/// f(x), loop by loop.
double net(const std::vector<float>& w, const double x[3]) {
  const float *w1 = w.data(), *b1 = w1 + 384, *w2 = b1 + 128, *b2 = w2 + 16384, *w3 = b2 + 128;
  const auto silu = [](double z) { return z / (1 + std::exp(-z)); };
  double a[128], f = double(w3[128]);
  for (int k = 0; k < 128; ++k) {
    double z = double(b1[k]);
    for (int m = 0; m < 3; ++m) z += double(w1[3 * k + m]) * x[m];
    a[k] = silu(z);
  }
  for (int k = 0; k < 128; ++k) {
    double z = double(b2[k]);
    for (int m = 0; m < 128; ++m) z += double(w2[128 * k + m]) * a[m];
    f += double(w3[k]) * silu(z);
  }
  return f;
}

/// psi_theta/E from the formula, the slopes of f at rest by central differences.
double energy(const std::vector<float>& w, double nu, const double e[3]) {
  const double omega = 1 / (1 - 2 * nu), a = std::sqrt((1 - 2 * nu) / (1 + nu)), b = (1 - a) / 3;
  const double rest[3] = {};
  double slope[2], sum = 0;
  for (int m = 0; m < 2; ++m) {
    constexpr double kStep = 1e-5;
    double up[3] = {}, down[3] = {};
    up[m] = kStep, down[m] = -kStep;
    slope[m] = (net(w, up) - net(w, down)) / (2 * kStep);
  }
  for (int i = 0; i < 3; ++i) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    const double x[3] = {e[i], e[j] + e[k], e[j] * e[k]};
    double q = (a + b) * e[i] + b * (e[j] + e[k]) + net(w, x) - net(w, rest);
    for (int m = 0; m < 2; ++m) q -= slope[m] * x[m];
    sum += omega / 2 * q * q;
  }
  return sum;
}

TEST(NeuralMtl, EvaluatesTheFormula) {
  const std::vector<float> w = random_weights();
  for (const double nu : {0.0, 0.3, 0.49}) {
    const NeuralMtl mtl(w, nu);
    const std::vector<double> e = strains(20, 5, 0.9, 0.69);
    std::vector<LogJet> jets(20);
    mtl.evaluate<true>(e.data(), 20, jets.data());
    std::vector<double> q(60);
    mtl.strains(e.data(), 20, q.data());
    for (size_t k = 0; k < 20; ++k) {
      const double reference = energy(w, nu, e.data() + 3 * k);
      EXPECT_NEAR(jets[k].psi, reference, 1e-9 * (1 + reference)) << nu;
      const double omega = 1 / (1 - 2 * nu), size = length(q.data() + 3 * k, 3);
      EXPECT_NEAR(omega / 2 * size * size, jets[k].psi, 1e-13 * (1 + reference));
    }
  }
}

/// f and its derivatives at x, unit by unit as a warp of the device takes them.
void unit_jets(const std::vector<float>& w, const double x[3], double f[10]) {
  const float *w1 = w.data(), *b1 = w1 + 384, *w2 = b1 + 128, *b2 = w2 + 16384, *w3 = b2 + 128;
  double hidden[128][10];
  for (int k = 0; k < 128; ++k) mtl::first_unit<10>(w1 + 3 * k, b1[k], x, hidden[k]);
  std::fill_n(f, 10, 0.0);
  for (int k = 0; k < 128; ++k) {
    double z[10] = {};
    for (int m = 0; m < 128; ++m)
      for (int c = 0; c < 10; ++c) z[c] += double(w2[128 * k + m]) * hidden[m][c];
    z[0] += double(b2[k]);
    mtl::activate<10>(z);
    for (int c = 0; c < 10; ++c) f[c] += double(w3[k]) * z[c];
  }
  f[0] += double(w3[128]);
}

TEST(NeuralMtl, UnitByUnitItIsTheSame) {
  const std::vector<float> w = random_weights();
  const std::vector<double> e = strains(20, 5, 0.9, 0.69);
  const NeuralMtl mtl(w, 0.4);
  std::vector<LogJet> jets(20);
  mtl.evaluate<true>(e.data(), 20, jets.data());
  for (size_t k = 0; k < 20; ++k) {
    mtl::Strain s[3];
    for (int i = 0; i < 3; ++i) {
      double x[3], f[10];
      mtl::inputs(e.data() + 3 * k, i, x);
      unit_jets(w, x, f);
      s[i] = mtl::strain<true>(e.data() + 3 * k, i, f, mtl.terms());
    }
    const LogJet found = mtl::energy<true>(s, mtl.terms().omega);
    EXPECT_NEAR(found.psi, jets[k].psi, 1e-13 * (1 + jets[k].psi));
    for (int m = 0; m < 3; ++m)
      EXPECT_NEAR(found.w[m], jets[k].w[m], 1e-12 * (1 + length(jets[k].w, 3)));
    for (int c = 0; c < 6; ++c)
      EXPECT_NEAR(found.ww[c], jets[k].ww[c], 1e-12 * (1 + length(jets[k].ww, 6)));
  }
}

TEST(NeuralMtl, IsExactAtRestForAnyWeights) {
  for (const uint64_t seed : {1, 2, 3})
    for (const double nu : {0.0, 0.45, 0.495}) {
      const NeuralMtl mtl(random_weights(seed), nu);
      const double rest[3] = {};
      LogJet jet;
      mtl.evaluate<true>(rest, 1, &jet);
      EXPECT_EQ(jet.psi, 0);
      for (int c = 0; c < 6; ++c) {
        const double exact = mtl.lambda() + (c < 3 ? 2 * mtl.mu() : 0);
        EXPECT_NEAR(jet.ww[c], exact, 1e-14 * (mtl.lambda() + 2 * mtl.mu()));
        if (c < 3) {
          EXPECT_EQ(jet.w[c], 0);
        }
      }
    }
}

TEST(NeuralMtl, DerivativesAreThoseOfTheEnergy) {
  const NeuralMtl mtl(random_weights(), 0.4);
  const std::vector<double> e = strains(50, 10, 0.9, 0.69);
  for (size_t k = 0; k < 50; ++k) {
    LogJet here;
    mtl.evaluate<true>(e.data() + 3 * k, 1, &here);
    for (int m = 0; m < 3; ++m) {
      constexpr double kStep = 1e-5;
      LogJet jets[2];
      double moved[6];
      for (int i = 0; i < 6; ++i)
        moved[i] = e[3 * k + size_t(i % 3)] + (i % 3 == m ? (i < 3 ? kStep : -kStep) : 0);
      mtl.evaluate<false>(moved, 2, jets);
      EXPECT_NEAR((jets[0].psi - jets[1].psi) / (2 * kStep), here.w[m], 2e-9);
      for (int c = 0; c < 6; ++c) {
        const int other = kFirst[c] == m ? kSecond[c] : kSecond[c] == m ? kFirst[c] : -1;
        if (other < 0) continue;
        EXPECT_NEAR((jets[0].w[other] - jets[1].w[other]) / (2 * kStep), here.ww[c], 2e-8);
      }
    }
  }
}

TEST(NeuralMtl, DoesNotTellAxesApart) {
  const NeuralMtl mtl(random_weights(), 0.3);
  const std::vector<double> e = strains(100, 20, 0.9, 0.69);
  for (size_t k = 0; k < 100; ++k) {
    const double a[3] = {e[3 * k], e[3 * k + 1], e[3 * k + 2]}, b[3] = {a[2], a[0], a[1]};
    LogJet first, turned;
    mtl.evaluate<true>(a, 1, &first);
    mtl.evaluate<true>(b, 1, &turned);
    EXPECT_NEAR(first.psi, turned.psi, 1e-13);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(first.w[i], turned.w[(i + 1) % 3], 1e-12);
      EXPECT_NEAR(first.ww[i], turned.ww[(i + 1) % 3], 1e-11);
      EXPECT_NEAR(first.ww[3 + i], turned.ww[3 + (i + 1) % 3], 1e-11);
    }
  }
}

TEST(NeuralMtl, RefusesWeightsOfAnotherShapeOrNotFinite) {
  std::vector<float> w = random_weights();
  w.back() = std::nanf("");
  EXPECT_THROW(NeuralMtl(w, 0.3), Error);
  w.pop_back();
  EXPECT_THROW(NeuralMtl(w, 0.3), Error);
  EXPECT_THROW(NeuralMtl(random_weights(), 0.5), Error);
}

}  // namespace
}  // namespace elastogen::test
