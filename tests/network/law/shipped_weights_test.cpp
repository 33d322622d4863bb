// SPDX-License-Identifier: Apache-2.0
// Every weight file of network/weights: its fit measured anew on other strains than its card's, by
// the net and by the table; the conditions on a law at rest; the published bias of the lagged loop.

#include "core/error.hpp"
#include "network/law/mtl_weights.hpp"
#include "network/paper/paper_model.hpp"
#include "tests/network/law/mtl_support.hpp"
#include "tests/support/matrices.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <sstream>

namespace elastogen::test {
namespace {

namespace fs = std::filesystem;

struct Shipped {
  std::string name;
  std::string bytes;
  Law law;
  double poisson;
};

std::vector<Shipped> shipped() {
  std::vector<Shipped> all;
  for (const fs::directory_entry& entry : fs::directory_iterator(ELASTOGEN_SHIPPED_WEIGHTS)) {
    if (entry.path().extension() != ".weights") continue;
    std::ostringstream bytes;
    bytes << std::ifstream(entry.path(), std::ios::binary).rdbuf();
    const TensorFile file = decode_tensors(bytes.str(), entry.path().filename());
    all.push_back({entry.path().filename(), bytes.str(), law_from_name(file.text.at("law")),
                   std::stod(file.text.at("poisson"))});
  }
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
  return all;
}

std::shared_ptr<const LearnedLaw> read(const Shipped& file, Evaluation evaluation) {
  return read_weights(file.bytes, file.name, file.law, file.poisson, evaluation);
}

TEST(ShippedWeights, KeepTheirLimitsByNetAndByTable) {
  const std::vector<Shipped> all = shipped();
  ASSERT_GE(all.size(), 40u);
  for (const Shipped& file : all) {
    EXPECT_EQ(file.name, weight_file_name(file.law, file.poisson));
    for (const Evaluation evaluation : {Evaluation::kNet, Evaluation::kTable}) {
      const FitErrors e = fit_errors(*read(file, evaluation), 4000, 11);
      EXPECT_TRUE(within(e)) << file.name << (evaluation == Evaluation::kNet ? " net" : " table")
                             << ": stress " << e.stress_median << ' ' << e.stress_p99 << ' '
                             << e.stress_max << " tangent " << e.tangent_p99;
    }
  }
}

// psi = 0, P = 0 and the moduli are exact for rotations, with any weights
TEST(ShippedWeights, AreExactAtRest) {
  for (const Shipped& file : shipped()) {
    const auto net = read(file, Evaluation::kTable);
    const LawParameters<double> p = parameters<double>(file.law, 1, file.poisson);
    double outside;
    const double rest[3] = {1, 1, 1};
    const Response<double> r = learned_response<true>(*net, p, rest, outside);
    const double scale = 2 * p.mu + p.lambda;
    EXPECT_NEAR(r.psi, 0, 1e-13 * scale) << file.name;
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(r.t[i], 0, 1e-10 * scale) << file.name;
    for (int c = 0; c < 6; ++c)
      EXPECT_NEAR(r.H[c], p.lambda + (c < 3 ? 2 * p.mu : 0), 1e-6 * scale) << file.name;
  }
}

/// psi and P of a net in F.
std::pair<double, Mat3<double>> energy_and_stress(const LearnedLaw& net,
                                                  const LawParameters<double>& p,
                                                  const Mat3<double>& F) {
  double outside;
  const Svd3<double> s = svd3(F);
  const Response<double> r = learned_response<false>(net, p, s.sigma, outside);
  return {r.psi, first_piola(s, r.t)};
}

// remainders of Taylor's formula fall as h^2: of psi with P, and of P with its Hessian in F
TEST(ShippedWeights, TaylorRemaindersFallWithOrderTwo) {
  std::mt19937_64 random(3);
  double lowest = 10, highest = 0;
  for (const Shipped& file : shipped()) {
    if (file.poisson != 0.3 && file.poisson != 0.45) continue;
    const LawParameters<double> p = parameters<double>(file.law, 1, file.poisson);
    for (const Evaluation evaluation : {Evaluation::kNet, Evaluation::kTable}) {
      const auto net = read(file, evaluation);
      for (int k = 0; k < 10; ++k) {
        Mat3<double> F = gaussian(random);
        const Mat3<double> dF = gaussian(random);
        for (int m = 0; m < 9; ++m) F.m[m] = (m % 4 == 0) + 0.15 * F.m[m];
        // stress and Hessian at F give the linear terms along dF
        double outside;
        const Svd3<double> s = svd3(F);
        const Response<double> r = learned_response<true>(*net, p, s.sigma, outside);
        const Mat3<double> P = first_piola(s, r.t),
                           dP = apply(principal_hessian(s.sigma, r), s, dF);
        double slope = 0, of_psi[2], of_P[2];
        for (int m = 0; m < 9; ++m) slope += P.m[m] * dF.m[m];
        // remainders at two step sizes
        const double steps[2] = {1e-3, 1e-5};
        for (int n = 0; n < 2; ++n) {
          Mat3<double> moved, linear;
          for (int m = 0; m < 9; ++m) {
            moved.m[m] = F.m[m] + steps[n] * dF.m[m];
            linear.m[m] = P.m[m] + steps[n] * dP.m[m];
          }
          const auto [psi, stress] = energy_and_stress(*net, p, moved);
          of_psi[n] = std::abs(psi - r.psi - steps[n] * slope);
          of_P[n] = distance(stress, linear);
        }
        for (const double* remainder : {of_psi, of_P}) {
          const double order = std::log10(remainder[0] / remainder[1]) / 2;
          lowest = std::min(lowest, order), highest = std::max(highest, order);
        }
      }
    }
  }
  std::printf("orders of remainders: %.3f to %.3f\n", lowest, highest);
  EXPECT_GE(lowest, 1.9);
  EXPECT_LE(highest, 2.1);
}

TEST(ShippedWeights, RotationsCostNothing) {
  std::mt19937_64 random(5);
  const Shipped file = shipped().front();
  const LawParameters<double> p = parameters<double>(file.law, 1, file.poisson);
  for (const Evaluation evaluation : {Evaluation::kNet, Evaluation::kTable}) {
    const auto net = read(file, evaluation);
    for (int k = 0; k < 20000; ++k) {
      const auto [psi, P] = energy_and_stress(*net, p, rotation(random));
      ASSERT_NEAR(psi, 0, 1e-13);
      ASSERT_LE(norm(P), 1e-13);
    }
  }
}

// psi(QF) = psi(F) = psi(FQ), P(QF) = Q P(F), P(FQ) = P(F) Q, and P F^T is symmetric
TEST(ShippedWeights, AreObjectiveAndIsotropic) {
  std::mt19937_64 random(6);
  std::normal_distribution<double> normal;
  for (const Shipped& file : shipped()) {
    if (file.poisson != 0.3 && file.poisson != 0.49) continue;
    const LawParameters<double> p = parameters<double>(file.law, 1, file.poisson);
    for (const Evaluation evaluation : {Evaluation::kNet, Evaluation::kTable}) {
      const auto net = read(file, evaluation);
      for (int k = 0; k < 50; ++k) {
        Mat3<double> F;
        for (int m = 0; m < 9; ++m) F.m[m] = (m % 4 == 0) + 0.2 * normal(random);
        // turned before and after
        const Mat3<double> Q = rotation(random);
        const auto [psi, P] = energy_and_stress(*net, p, F);
        const double scale = 1e-11 * (1 + psi + norm(P));
        const auto [turned_psi, turned] = energy_and_stress(*net, p, Q * F);
        EXPECT_NEAR(turned_psi, psi, scale) << file.name;
        EXPECT_LE(distance(turned, Q * P), scale) << file.name;
        const auto [other_psi, other] = energy_and_stress(*net, p, F * Q);
        EXPECT_NEAR(other_psi, psi, scale) << file.name;
        EXPECT_LE(distance(other, P * Q), scale) << file.name;
        // symmetric Kirchhoff stress
        const Mat3<double> tau = times_transposed(P, F);
        for (int i = 0; i < 3; ++i)
          EXPECT_NEAR(tau(i, (i + 1) % 3), tau((i + 1) % 3, i), scale) << file.name;
      }
    }
  }
}

TEST(ShippedWeights, StiffnessScalesOutAndTheProjectedHessianIsPositive) {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> log_stretch(-0.8, 0.8);
  for (const Shipped& file : shipped()) {
    const auto net = read(file, Evaluation::kTable);
    for (int k = 0; k < 20; ++k) {
      double s[3], outside;
      for (double& stretch : s) stretch = std::exp(log_stretch(random));
      // a thousandth and a million times as stiff
      const auto soft =
          learned_response<true>(*net, parameters<double>(file.law, 1, file.poisson), s, outside);
      for (const double c : {1e-3, 1e6}) {
        const auto stiff =
            learned_response<true>(*net, parameters<double>(file.law, c, file.poisson), s, outside);
        EXPECT_NEAR(stiff.psi, c * soft.psi, 1e-12 * c * (1 + soft.psi)) << file.name;
        for (int i = 0; i < 6; ++i)
          EXPECT_NEAR(stiff.H[i], c * soft.H[i], 1e-11 * c * (1 + std::abs(soft.H[i])));
      }
      // the projected Hessian along a random direction
      const PrincipalHessian<double> h = positive_part(principal_hessian(s, soft));
      double v[3], work = 0;
      for (double& x : v) x = log_stretch(random);
      for (int i = 0; i < 3; ++i) {
        work += h.A.m[i] * v[i] * v[i];
        work += 2 * h.A.m[3 + i] * v[i] * v[(i + 1) % 3];
      }
      EXPECT_GE(work, -1e-12 * (1 + std::abs(h.A.m[0]))) << file.name;
      for (int i = 0; i < 3; ++i) EXPECT_TRUE(h.twist[i] >= 0 && h.flip[i] >= 0) << file.name;
    }
  }
}

// the stretches at which the sides are free are those of the law, within the net's error
TEST(ShippedWeights, UniaxialStressIsThatOfTheLaw) {
  for (const Shipped& file : shipped()) {
    const auto net = read(file, Evaluation::kTable);
    const LawParameters<double> p = parameters<double>(file.law, 1, file.poisson);
    for (const double stretch : {0.8, 1.3, 2.0}) {
      double P[2];
      for (const bool by_net : {false, true}) {
        double low = 0.5, high = 1.5, outside;
        for (int k = 0; k < 60; ++k) {
          const double side = (low + high) / 2, s[3] = {stretch, side, side};
          const auto r = material_response<false>(by_net ? net.get() : nullptr, p, s, outside);
          (r.t[2] < 0 ? low : high) = side;
          P[by_net] = r.t[0];
        }
      }
      EXPECT_NEAR(P[1], P[0], 3e-3 * std::abs(P[0])) << file.name << ' ' << stretch;
    }
  }
}

// the lagged loop with omega = E sees sqrt(omega k): volume sqrt(1-2nu), shear sqrt(1+nu)
TEST(ShippedWeights, LaggedLoopHasThePublishedBias) {
  for (const Shipped& file : shipped()) {
    const auto net = read(file, Evaluation::kNet);
    const LawParameters<double> p = parameters<double>(file.law, 1, file.poisson);
    const double size = 1e-4, nu = file.poisson;
    const auto lagged = [&](const double s[3], int i) {
      double n[3];
      energy_fitted_stretches(net.get(), p, s, n);
      return (s[i] * n[i] - 1) * n[i];  // omega = E = 1
    };
    const double volume[3] = {1 + size, 1 + size, 1 + size}, shear[3] = {1 + size, 1, 1 - size};
    const double bulk = lagged(volume, 0) / size * (1 - 2 * nu);  // over 3K/E
    const double twice_mu = lagged(shear, 0) / size * (1 + nu);   // over 2 mu/E
    EXPECT_NEAR(bulk, std::sqrt(1 - 2 * nu), 1e-3) << file.name;
    EXPECT_NEAR(twice_mu, std::sqrt(1 + nu), 1e-3) << file.name;
  }
}

}  // namespace
}  // namespace elastogen::test
