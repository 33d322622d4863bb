// SPDX-License-Identifier: Apache-2.0
#include "core/elastic_law.hpp"

#include "core/error.hpp"
#include "tests/support/laws.hpp"

#include <gtest/gtest.h>

#include <random>

namespace elastogen {
namespace {

using test::kLaws;
using test::parameters;

/// The families in the invariants of C without its volume (Holzapfel, Nonlinear Solid Mechanics,
/// 6.5), with the volumetric energy K/2 (ln J)^2.
long double textbook_psi_of_family(const Law& law, long double mu, long double lambda,
                                   const double s[3]) {
  const long double x = s[0], y = s[1], z = s[2], J = x * y * z, root = std::cbrt(J);
  const long double I1 = (x * x + y * y + z * z) / (root * root);
  const long double I2 = (x * x * y * y + y * y * z * z + z * z * x * x) / (J * root);
  const long double volume = (lambda + 2 * mu / 3) / 2 * std::log(J) * std::log(J);
  const long double a = law.shape;
  if (law.kind == Law::Kind::kGent) return -mu * a / 2 * std::log(1 - (I1 - 3) / a) + volume;
  if (law.kind == Law::Kind::kMooneyRivlin)
    return mu / 2 * ((1 - a) * (I1 - 3) + a * (I2 - 3)) + volume;
  const long double sum = std::pow(x / root, a) + std::pow(y / root, a) + std::pow(z / root, a);
  return 2 * mu / (a * a) * (sum - 3) + volume;
}

/// psi as the literature prints it, for stretches where no law is continued.
long double textbook_psi(const Law& law, long double mu, long double lambda, const double s[3]) {
  if (law.shape != 0) return textbook_psi_of_family(law, mu, lambda, s);
  long double e2 = 0, trace = 0, I = 0, J = 1;
  for (int i = 0; i < 3; ++i) {
    const long double x = s[i];
    const long double e = law == Law::kStvk     ? (x * x - 1) / 2
                          : law == Law::kHencky ? std::log(x)
                                                : x - 1;
    e2 += e * e, trace += e, I += x * x, J *= x;
  }
  switch (law.kind) {
    case Law::Kind::kFixedCorotated:
      return mu * e2 + lambda / 2 * (J - 1) * (J - 1);
    case Law::Kind::kNeoHookean:
      return mu / 2 * (I - 3) - mu * std::log(J) + lambda / 2 * std::log(J) * std::log(J);
    case Law::Kind::kStableNeoHookean: {
      const long double m = 4 * mu / 3, l = lambda + 5 * mu / 6, a = 1 + 3 * m / (4 * l);
      return m / 2 * (I - 3 - std::log((I + 1) / 4)) +
             l / 2 * ((J - a) * (J - a) - (1 - a) * (1 - a));
    }
    default:
      return mu * e2 + lambda / 2 * trace * trace;
  }
}

Response<double> response(const LawParameters<double>& law, double a, double b, double c) {
  const double s[3] = {a, b, c};
  return elastic_response<true>(law, s);
}

/// Stretch b at which the stress on the free faces vanishes; `faces` of them are free (1 or 2).
double free_stretch(const LawParameters<double>& law, double a, int faces) {
  double low = 0.1, high = 1.5;
  for (int k = 0; k < 80; ++k) {
    const double b = (low + high) / 2;
    (response(law, a, faces == 1 ? a : b, b).t[2] < 0 ? low : high) = b;
  }
  return (low + high) / 2;
}

struct Row {
  double stretch, P, lateral;
};

void expect_rows(Law kind, int faces, const std::vector<Row>& rows) {
  const LawParameters<double> law = parameters<double>(kind, 1, 0.3);
  for (const Row& row : rows) {
    SCOPED_TRACE(law_name(kind));
    const double b = free_stretch(law, row.stretch, faces);
    EXPECT_NEAR(b, row.lateral, 1e-6) << row.stretch;
    const double a = row.stretch;
    EXPECT_NEAR(response(law, a, faces == 1 ? a : b, b).t[0], row.P, 1e-6) << a;
  }
}

TEST(ElasticLaw, PsiIsTheTextbookEnergy) {
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> stretch(0.5, 2);
  for (const Law kind : kLaws)
    for (int k = 0; k < 2000; ++k) {
      const LawParameters<double> law = parameters<double>(kind, 3, 0.4);
      const double s[3] = {stretch(random), stretch(random), stretch(random)};
      const double reference = double(textbook_psi(kind, law.mu, law.lambda, s));
      ASSERT_NEAR(elastic_response<false>(law, s).psi, reference, 1e-13 * (1 + reference))
          << law_name(kind);
    }
}

TEST(ElasticLaw, GradientAndHessianAreDerivativesAlsoWhereTheLawIsContinuedOrInverted) {
  // apart, equal, flat, inverted and nearly collapsed
  const double samples[][3] = {{1.3, 0.9, 0.7},    {2, 1.1, 0.6},     {1, 1, 1},
                               {1.2, 1.2, 0.06},   {1.5, 0.3, 0.05},  {1.4, 0.8, -0.5},
                               {0.05, 0.04, 0.03}, {1.1, 0.9, -0.01}, {3, 2, 1.7}};
  constexpr double d = 1e-5;
  for (const Law kind : kLaws) {
    const LawParameters<double> law = parameters<double>(kind, 1, 0.4);
    for (const auto& s : samples) {
      SCOPED_TRACE(concat(law_name(kind), " at ", s[0], ", ", s[1], ", ", s[2]));
      const Response<double> r = elastic_response<true>(law, s);
      // central differences along each stretch
      for (int j = 0; j < 3; ++j) {
        double up[3] = {s[0], s[1], s[2]}, down[3] = {s[0], s[1], s[2]};
        up[j] += d, down[j] -= d;
        const Response<double> a = elastic_response<false>(law, up);
        const Response<double> b = elastic_response<false>(law, down);
        const double size = 1 + std::abs(r.t[j]) + std::abs(r.H[j]);
        EXPECT_NEAR((a.psi - b.psi) / (2 * d), r.t[j], 1e-7 * size);
        for (int i = 0; i < 3; ++i) {
          const int entry = i == j ? i : 3 + ((i + 1) % 3 == j ? i : j);
          EXPECT_NEAR((a.t[i] - b.t[i]) / (2 * d), r.H[entry], 1e-6 * size);
        }
      }
    }
  }
}

TEST(ElasticLaw, RestIsFreeOfEnergyAndStressWithTheModuliOfTheMaterial) {
  for (const Law kind : kLaws) {
    SCOPED_TRACE(law_name(kind));
    const LawParameters<double> law = parameters<double>(kind, 2e6, 0.45);
    const Response<double> r = response(law, 1, 1, 1);
    EXPECT_EQ(r.psi, 0);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(r.t[i], 0);
      EXPECT_NEAR(r.H[i], 2 * law.mu + law.lambda, 1e-9 * law.lambda);
      EXPECT_NEAR(r.H[3 + i], law.lambda, 1e-9 * law.lambda);
    }
  }
}

TEST(ElasticLaw, UniaxialStressAndLateralStretchAreThoseOfTheTables) {
  expect_rows(Law::kNeoHookean, 2,
              {{0.5, -0.935352, 1.210767},
               {0.7, -0.405230, 1.107935},
               {0.9, -0.108722, 1.031702},
               {1.1, 0.093077, 0.971493},
               {1.5, 0.378280, 0.880175},
               {2.0, 0.646745, 0.798078}});
  expect_rows(Law::kStableNeoHookean, 2,
              {{0.5, -0.705854, 1.094647},
               {0.7, -0.372900, 1.085299},
               {0.9, -0.106749, 1.030160},
               {1.1, 0.094488, 0.970469},
               {1.5, 0.404446, 0.867086},
               {2.0, 0.732113, 0.771045}});
  expect_rows(Law::kFixedCorotated, 2,
              {{0.5, -0.644286, 1.147137},
               {0.7, -0.343171, 1.093536},
               {0.9, -0.103902, 1.030628},
               {1.1, 0.096792, 0.970730},
               {1.5, 0.442869, 0.869332},
               {2.0, 0.836684, 0.773170}});
}

TEST(ElasticLaw, UniaxialStressOfStvkAndHenckyHasClosedForms) {
  std::vector<Row> stvk, hencky;
  for (const double a : {0.5, 0.7, 0.9, 1.1, 1.5, 2.0}) {
    stvk.push_back({a, a * (a * a - 1) / 2, std::sqrt(1 - 0.3 * (a * a - 1))});
    hencky.push_back({a, std::log(a) / a, std::pow(a, -0.3)});
  }
  expect_rows(Law::kStvk, 2, stvk);
  expect_rows(Law::kHencky, 2, hencky);
}

TEST(ElasticLaw, EquibiaxialStressAndLateralStretchAreThoseOfTheTables) {
  expect_rows(Law::kNeoHookean, 1, {{1.2, 0.233989, 0.842587}, {1.5, 0.467916, 0.652019}});
  expect_rows(Law::kStableNeoHookean, 1, {{1.2, 0.257776, 0.816537}, {1.5, 0.541941, 0.580612}});
  expect_rows(Law::kFixedCorotated, 1, {{1.2, 0.250889, 0.814026}, {1.5, 0.510958, 0.560261}});
  expect_rows(Law::kStvk, 1, {{1.2, 0.377143, 0.789213}});
}

TEST(ElasticLaw, ConfinedCompressionIsThatOfTheTables) {
  const auto stress = [](Law kind, double a) {
    return response(parameters<double>(kind, 1, 0.3), a, 1, 1).t[0];
  };
  EXPECT_NEAR(stress(Law::kNeoHookean, 0.5), -1.376708, 1e-6);
  EXPECT_NEAR(stress(Law::kStableNeoHookean, 0.5), -0.655819, 1e-6);
  EXPECT_NEAR(stress(Law::kFixedCorotated, 0.5), -0.673077, 1e-6);
  EXPECT_NEAR(stress(Law::kStvk, 0.5), -0.252404, 1e-6);
  EXPECT_NEAR(stress(Law::kHencky, 0.5), 0.7 / (1.3 * 0.4) * std::log(0.5) / 0.5, 1e-12);
}

TEST(ElasticLaw, ConfinedStvkSoftensBelowItsLimitPoint) {
  const LawParameters<double> law = parameters<double>(Law::kStvk, 1, 0.3);
  const Response<double> limit = response(law, 1 / std::sqrt(3.0), 1, 1);
  EXPECT_NEAR(limit.t[0], -0.259067, 1e-6);
  EXPECT_NEAR(limit.H[0], 0, 1e-12);
}

TEST(ElasticLaw, EnergyScalesWithTheModuli) {
  for (const Law kind : kLaws)
    for (const double c : {1e-3, 1.0, 1e6}) {
      const Response<double> one = response(parameters<double>(kind, 1, 0.4), 1.4, 1.1, 0.3);
      const Response<double> many = response(parameters<double>(kind, c, 0.4), 1.4, 1.1, 0.3);
      EXPECT_NEAR(many.psi, c * one.psi, 1e-12 * c * one.psi) << law_name(kind);
      for (int i = 0; i < 3; ++i) EXPECT_NEAR(many.t[i], c * one.t[i], 1e-12 * c);
    }
}

TEST(ElasticLaw, ContinuedLogarithmIsTwiceContinuouslyDifferentiableAndMonotone) {
  const auto at = [](double y) { return law::continued_log(y - 1); };
  EXPECT_NEAR(at(0.1).value, std::log(0.1), 1e-14);
  for (const double y : {0.1 - 1e-9, 0.1, 0.1 + 1e-9}) {
    EXPECT_NEAR(at(y).value, std::log(0.1), 2e-8);
    EXPECT_NEAR(at(y).first, 10, 2e-6);
    EXPECT_NEAR(at(y).second, -100, 3e-5 * 100);
  }
  for (double y = -2; y < 2; y += 0.0371) {
    constexpr double d = 1e-6;
    const double size = 1 + std::abs(at(y).second);
    EXPECT_NEAR((at(y + d).value - at(y - d).value) / (2 * d), at(y).first, 1e-7 * size) << y;
    EXPECT_NEAR((at(y + d).first - at(y - d).first) / (2 * d), at(y).second, 1e-6 * size) << y;
    EXPECT_GT(at(y).first, 0) << y;
  }
}

TEST(ElasticLaw, ContinuedExponentialIsTwiceContinuouslyDifferentiableAndKeepsItsDigits) {
  const auto at = [](double x) { return law::continued_exp(x); };
  for (const double x : {-9.0, -1.0 - 1e-9, -1.0 + 1e-9, -0.3, 0.7, 1 - 1e-9, 1 + 1e-9, 11.9}) {
    const long double exact = std::expm1(static_cast<long double>(x)) - x;
    EXPECT_NEAR(at(x).value, double(exact), 4e-16 * double(std::abs(exact)) + 2e-16) << x;
    EXPECT_NEAR(at(x).first, std::expm1(x), 4e-16 * (std::abs(x) + std::exp(x))) << x;
    EXPECT_DOUBLE_EQ(at(x).second, std::exp(x)) << x;
  }
  for (const double x : {1e-12, -1e-8, 1e-4})  // x^2/2 + x^3/6
    EXPECT_NEAR(at(x).value / (x * x / 2 * (1 + x / 3 * (1 + x / 4))), 1, 1e-12);
  for (double x = 11; x < 16; x += 0.073) {
    constexpr double d = 1e-5;
    EXPECT_NEAR((at(x + d).value - at(x - d).value) / (2 * d), at(x).first, 1e-4) << x;
    EXPECT_NEAR((at(x + d).first - at(x - d).first) / (2 * d), at(x).second, 2) << x;
  }
  EXPECT_EQ(at(13).second, at(12).second);
}

TEST(ElasticLaw, OgdenWithoutExponentIsHencky) {
  for (const double exponent : {0.0, 1e-9, -1e-7}) {
    const double s[3] = {1.4, 0.8, 0.95};
    const auto hencky = elastic_response<true>(parameters<double>(Law::kHencky, 1, 0.3), s);
    const auto ogden = elastic_response<true>(parameters<double>(Law::ogden(exponent), 1, 0.3), s);
    EXPECT_NEAR(ogden.psi, hencky.psi, 1e-6 * hencky.psi);
    for (int i = 0; i < 3; ++i) EXPECT_NEAR(ogden.t[i], hencky.t[i], 1e-6);
    for (int i = 0; i < 6; ++i) EXPECT_NEAR(ogden.H[i], hencky.H[i], 2e-6);
  }
}

TEST(ElasticLaw, PackOfFloatKeepsItsDigitsNearRest) {
  // stretches given in float, evaluated in both formats: the difference is rounding in the law
  std::mt19937_64 random(2);
  std::uniform_real_distribution<float> unit(-1, 1);
  for (const Law kind : kLaws)
    for (const float strain : {1e-5f, 1e-3f, 0.3f}) {
      const auto low = parameters<float>(kind, 1, 0.4);
      const LawParameters<double> high{kind, low.mu, low.lambda};
      Pack<float> s[3];
      for (Pack<float>& stretch : s)
        for (int k = 0; k < kLanes; ++k) stretch[k] = 1 + strain * unit(random);
      const Response<Pack<float>> r = elastic_response<true>(low, s);
      for (int k = 0; k < kLanes; ++k) {
        const Response<double> exact = response(high, s[0][k], s[1][k], s[2][k]);
        for (int i = 0; i < 3; ++i) {
          EXPECT_NEAR(r.t[i][k], exact.t[i], 4e-6 * strain) << law_name(kind) << strain;
          EXPECT_NEAR(r.H[i][k], exact.H[i], 1e-5) << law_name(kind);
          EXPECT_NEAR(r.H[3 + i][k], exact.H[3 + i], 1e-5) << law_name(kind);
        }
      }
    }
}

}  // namespace
}  // namespace elastogen
