// SPDX-License-Identifier: Apache-2.0
// Every weight file of network/weights: its fit measured anew on other strains than its card's, by
// the net and by the table; what must hold of a law at rest; the published bias of the lagged loop.

#include "core/error.hpp"
#include "network/mtl_weights.hpp"
#include "network/paper_model.hpp"
#include "tests/network/mtl_support.hpp"
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

// psi = 0, P = 0 and the moduli are exact for rotations, whatever the weights
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

// remainders of Taylor's formula fall as h^2 for P and for the Hessian in F
TEST(ShippedWeights, TaylorRemaindersFallWithOrderTwo) {
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (const Shipped& file : shipped()) {
    if (file.poisson != 0.3 && file.poisson != 0.45) continue;
    const auto net = read(file, Evaluation::kTable);
    const LawParameters<double> p = parameters<double>(file.law, 1, file.poisson);
    const auto energy = [&](const Mat3<double>& F) {
      double outside;
      return learned_response<false>(*net, p, svd3(F).sigma, outside).psi;
    };
    for (int k = 0; k < 20; ++k) {
      Mat3<double> F, dF;
      for (int m = 0; m < 9; ++m) {
        F.m[m] = (m % 4 == 0) + 0.15 * normal(random);
        dF.m[m] = normal(random);
      }
      double outside;
      const Svd3<double> s = svd3(F);
      const Response<double> r = learned_response<true>(*net, p, s.sigma, outside);
      const Mat3<double> P = first_piola(s, r.t);
      const Mat3<double> dP = apply(principal_hessian(s.sigma, r), s, dF);
      double slope = 0, curvature = 0;
      for (int m = 0; m < 9; ++m) slope += P.m[m] * dF.m[m], curvature += dP.m[m] * dF.m[m];
      const auto moved = [&](double h) {
        Mat3<double> G;
        for (int m = 0; m < 9; ++m) G.m[m] = F.m[m] + h * dF.m[m];
        return energy(G);
      };
      const double h = 1e-4;
      const double first = (moved(h) - moved(-h)) / (2 * h);
      const double second = (moved(h) - 2 * r.psi + moved(-h)) / (h * h);
      EXPECT_NEAR(first, slope, 1e-6 * (1 + std::abs(slope))) << file.name;
      EXPECT_NEAR(second, curvature, 2e-3 * (10 + std::abs(curvature))) << file.name;
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
