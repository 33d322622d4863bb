// SPDX-License-Identifier: Apache-2.0
#include "training/law_targets.hpp"

#include "tests/training/scalar_mtl.hpp"
#include "training/strain_sampler.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

/// Targets of some materials with second derivatives of the first strains.
struct Targets {
  Targets(const std::vector<FitMaterial>& materials, const Array<double>& e, int64_t second)
      : psi(materials.size() * e.rows()), t(3 * psi.size()), H(6 * materials.size() * second) {
    std::vector<TargetLaw> laws;
    for (const FitMaterial& m : materials) laws.push_back(target_law(m));
    cpu::law_targets(laws.data(), int64_t(laws.size()), e.data(), e.rows(),
                     {psi.data(), t.data(), H.data(), second});
  }
  std::vector<float> psi, t, H;
};

/// Energy of a sum of laws at stretches s.
double energy(const FitMaterial& m, const Vec3& s) {
  double sum = 0;
  for (const LawTerm& term : m.terms)
    sum +=
        term.weight *
        elastic_response<false>(LawParameters<double>{term.law, m.mu(), m.lambda()}, s.data()).psi;
  return sum;
}

double slope(const FitMaterial& m, Vec3 s, int i) {
  return test::slope(
      [&](double d) {
        Vec3 at = s;
        at[i] += d;
        return energy(m, at);
      },
      1e-3);
}

TEST(LawTargets, AreEnergyAndItsDerivativesOfEachMaterial) {
  const std::vector<FitMaterial> materials = {fit_material("neo-hookean", 0.3),
                                              fit_material("0.4*stvk+0.6*fixed-corotated", 0.45)};
  const Array<double> e = sample_strains({0.5, 0.3}, 1, 0, 12);
  const int64_t strains = e.rows(), second = 5;
  const Targets targets(materials, e, second);
  constexpr int row[6] = {0, 1, 2, 0, 1, 2}, column[6] = {0, 1, 2, 1, 2, 0};
  for (int64_t m = 0; m < 2; ++m) {
    const FitMaterial& material = materials[size_t(m)];
    const double modulus = 2 * material.mu() + material.lambda();
    for (int64_t n = 0; n < strains; ++n) {
      const Vec3 s = {std::exp(e(n, 0)), std::exp(e(n, 1)), std::exp(e(n, 2))};
      const double psi = energy(material, s);
      EXPECT_NEAR(targets.psi[size_t(m * strains + n)], psi, 1e-7 * psi + 1e-12);
      // stress and tangent by differences
      for (int i = 0; i < 3; ++i)
        EXPECT_NEAR(targets.t[size_t((3 * m + i) * strains + n)], slope(material, s, i),
                    1e-6 * modulus);
      for (int k = 0; n < second && k < 6; ++k) {
        const double H = test::slope(
            [&](double d) {
              Vec3 at = s;
              at[column[k]] += d;
              return slope(material, at, row[k]);
            },
            4e-3);
        EXPECT_NEAR(targets.H[size_t((6 * m + k) * second + n)], H, 1e-5 * modulus);
      }
    }
  }
}

TEST(LawTargets, AreLinearElasticityAtRest) {
  const std::vector<FitMaterial> materials = {fit_material(
      "0.2*stvk+0.2*hencky+0.2*neo-hookean+0.2*stable-neo-hookean+0.2*fixed-corotated", 0.4)};
  const Targets targets(materials, Array<double>(1, 3), 1);
  const double mu = materials[0].mu(), lambda = materials[0].lambda();
  EXPECT_NEAR(targets.psi[0], 0, 1e-15);
  for (int k = 0; k < 6; ++k)
    EXPECT_NEAR(targets.H[size_t(k)], lambda + (k < 3 ? 2 * mu : 0), 1e-6);
  for (const float t : targets.t) EXPECT_NEAR(t, 0, 1e-15);
}

}  // namespace
}  // namespace elastogen
