// SPDX-License-Identifier: Apache-2.0
#include "training/material_test.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace elastogen {
namespace {

constexpr double kYoung = 1.7e6;  // [Pa]

/// Lame constants and bulk modulus of E = kYoung [Pa].
struct Moduli {
  double mu, lambda, bulk;

  explicit Moduli(double nu)
      : mu(kYoung / (2 * (1 + nu))),
        lambda(kYoung * nu / ((1 + nu) * (1 - 2 * nu))),
        bulk(lambda + 2 * mu / 3) {}
};

/// Points of a law with energy f(e') + K/2 tr^2 in log stretches, from the derivatives of f: a
/// deviator (2g, -g, -g) or (g, g, -2g) with w_i = f_i - mean f + K tr has its free axis without
/// stress at the tr below, so nothing is solved for.
template <class Derivative>
std::vector<TestPoint> split_points(double nu, const Derivative& f) {
  std::vector<TestPoint> points;
  const double bulk = Moduli(nu).bulk;
  for (int k = -8; k <= 10; ++k) {
    const double g = 0.04 * k;
    const auto one = f(Vec3{2 * g, -g, -g}), two = f(Vec3{g, g, -2 * g});
    const auto w = [](const Vec3& a, int i) { return a[size_t(i)] - (a[0] + a[1] + a[2]) / 3; };
    const double trace1 = -w(one, 1) / bulk, trace2 = -w(two, 2) / bulk;
    const double l1 = std::exp(2 * g + trace1 / 3), l2 = std::exp(g + trace2 / 3);
    points.push_back({LoadPath::kUniaxial, l1, (w(one, 0) + bulk * trace1) / l1});
    points.push_back({LoadPath::kBiaxial, l2, (w(two, 0) + bulk * trace2) / l2});
  }
  return points;
}

/// df/de'_i of Ogden's energy 2 mu/a^2 sum exp(a e'_i).
Vec3 ogden(double mu, double a, const Vec3& e) {
  Vec3 d;
  for (size_t i = 0; i < 3; ++i) d[i] = 2 * mu / a * std::exp(a * e[i]);
  return d;
}

std::vector<TestPoint> ogden_points(double nu, double exponent) {
  return split_points(nu, [&](const Vec3& e) { return ogden(Moduli(nu).mu, exponent, e); });
}

std::vector<TestPoint> mooney_points(double nu, double share) {
  const double mu = Moduli(nu).mu;
  return split_points(nu, [&](const Vec3& e) {
    Vec3 d = ogden(mu * (1 - share), 2, e);
    const Vec3 other = ogden(mu * share, -2, e);
    for (size_t i = 0; i < 3; ++i) d[i] += other[i];
    return d;
  });
}

std::vector<TestPoint> gent_points(double nu, double limit) {
  return split_points(nu, [&](const Vec3& e) {
    double I1 = 0;
    for (const double x : e) I1 += std::exp(2 * x);
    return ogden(Moduli(nu).mu / (1 - (I1 - 3) / limit), 2, e);
  });
}

/// Uniaxial and planar tension of laws whose free side b gives the stretch in closed form.
std::vector<TestPoint> neo_hookean_points(double nu) {
  const Moduli m(nu);
  std::vector<TestPoint> points;
  for (double b = 0.6; b < 1.25; b += 0.05) {
    const double log_J = -m.mu / m.lambda * (b * b - 1), J = std::exp(log_J);
    for (const LoadPath path : {LoadPath::kUniaxial, LoadPath::kShear}) {
      const double l = J / (path == LoadPath::kShear ? b : b * b);
      points.push_back({path, l, m.mu * (l - 1 / l) + m.lambda * log_J / l});
    }
  }
  return points;
}

std::vector<TestPoint> hencky_points(double nu) {
  std::vector<TestPoint> points;
  for (double l = 0.5; l < 2; l += 0.1) {
    const double stress = kYoung * std::log(l) / l;
    points.push_back({LoadPath::kUniaxial, l, stress});
    points.push_back({LoadPath::kBiaxial, l, stress / (1 - nu)});
    points.push_back({LoadPath::kShear, l, stress / (1 - nu * nu)});
  }
  return points;
}

std::vector<TestPoint> stvk_points() {
  std::vector<TestPoint> points;
  for (double l = 0.7; l < 1.4; l += 0.05)
    points.push_back({LoadPath::kUniaxial, l, kYoung * l * (l * l - 1) / 2});
  return points;
}

/// 2 mu (b - 1) + lambda (J - 1) l b = 0, J = l b^2, is quadratic in l.
std::vector<TestPoint> corotated_points(double nu) {
  const Moduli m(nu);
  std::vector<TestPoint> points;
  for (double b = 0.75; b < 1.2; b += 0.05) {
    const double p = 2 * m.mu * (b - 1) / (m.lambda * b);  // b^2 l^2 - l + p = 0
    const double l = (1 + std::sqrt(1 - 4 * b * b * p)) / (2 * b * b);
    points.push_back(
        {LoadPath::kUniaxial, l, 2 * m.mu * (l - 1) + m.lambda * (l * b * b - 1) * b * b});
  }
  return points;
}

/// m b (1 - 1/(I+1)) + l' (J - a) l b = 0 with the stretch found by bisection.
std::vector<TestPoint> stable_points(double nu) {
  const Moduli moduli(nu);
  const double m = 4 * moduli.mu / 3, k = moduli.lambda + 5 * moduli.mu / 6, a = 1 + 3 * m / 4 / k;
  std::vector<TestPoint> points;
  for (double l = 0.6; l < 2; l += 0.1) {
    const auto shear = [&](double b) { return 1 - 1 / (l * l + 2 * b * b + 1); };
    double low = 0.1, high = 3;
    for (int n = 0; n < 200; ++n) {
      const double b = (low + high) / 2;
      (m * shear(b) + k * (l * b * b - a) * l > 0 ? high : low) = b;
    }
    const double b = low;
    points.push_back({LoadPath::kUniaxial, l, m * l * shear(b) + k * (l * b * b - a) * b * b});
  }
  return points;
}

TEST(MaterialTest, RecoversLawsWithoutShape) {
  const double nu = 0.42;
  struct {
    Law law;
    std::vector<TestPoint> points;
  } const kCases[] = {{Law::kHencky, hencky_points(nu)},
                      {Law::kNeoHookean, neo_hookean_points(nu)},
                      {Law::kStvk, stvk_points()},
                      {Law::kFixedCorotated, corotated_points(nu)},
                      {Law::kStableNeoHookean, stable_points(nu)}};
  for (const auto& c : kCases) {
    const TestFit fit = fit_test({c.law}, nu, c.points);
    EXPECT_NEAR(fit.young, kYoung, 1e-6 * kYoung) << law_name(c.law);
    EXPECT_LT(fit.error, 1e-9) << law_name(c.law);
    EXPECT_LT(fit.worst_error, 1e-8) << law_name(c.law);
    EXPECT_EQ(fit_tests(test_laws(), nu, c.points)[0].law, c.law);
  }
}

TEST(MaterialTest, RecoversShapeParameters) {
  for (const double nu : {0.3, 0.48})
    for (const auto& [law, points] : std::initializer_list<std::pair<Law, std::vector<TestPoint>>>{
             {Law::ogden(4.3), ogden_points(nu, 4.3)},
             {Law::ogden(-2.7), ogden_points(nu, -2.7)},
             {Law::mooney_rivlin(0.35), mooney_points(nu, 0.35)},
             {Law::gent(14.5), gent_points(nu, 14.5)}}) {
      const TestFit fit = fit_test({{law.kind}, true}, nu, points);
      EXPECT_NEAR(fit.young, kYoung, 1e-6 * kYoung) << law_name(law);
      EXPECT_NEAR(fit.law.shape, law.shape, 1e-4 * std::abs(law.shape)) << law_name(law);
      EXPECT_LT(fit.error, 1e-6) << law_name(law);
      EXPECT_FALSE(fit.at_end);
      EXPECT_EQ(fit_tests(test_laws(), nu, points)[0].law.kind, law.kind);
    }
}

TEST(MaterialTest, ComesNearTheIncompressibleMooneyRivlinBody) {
  // Mooney and Rivlin without volume change: 2 (l - l^-2)(c10 + c01/l), E = 6 (c10 + c01)
  const double c10 = 0.2e6, c01 = 0.05e6;
  std::vector<TestPoint> points;
  for (double l = 1.1; l < 2.6; l += 0.1)
    points.push_back({LoadPath::kUniaxial, l, 2 * (l - 1 / (l * l)) * (c10 + c01 / l)});
  const TestFit fit = fit_test({Law::mooney_rivlin(0), true}, 0.499, points);
  EXPECT_NEAR(fit.young, 6 * (c10 + c01), 2e-3 * fit.young);
  EXPECT_NEAR(fit.law.shape, c01 / (c10 + c01), 5e-3);
  EXPECT_LT(fit.error, 1e-3);
  // further from incompressible the same body is further away
  EXPECT_GT(fit_test({Law::mooney_rivlin(0), true}, 0.45, points).error, 3 * fit.error);
}

TEST(MaterialTest, PrefersAStiffeningLawForACurveLikeTreloars) {
  // Treloar's curve turns up: Gent without volume change, mu L/(L - I1 + 3) (l - l^-2)
  const double mu = 0.3e6, limit = 70;
  std::vector<TestPoint> points;
  for (double l = 1.2; l < 5; l += 0.2) {
    const double excess = l * l + 2 / l - 3;
    points.push_back({LoadPath::kUniaxial, l, mu * limit / (limit - excess) * (l - 1 / (l * l))});
  }
  const std::vector<TestFit> fits = fit_tests(test_laws(), 0.499, points);
  EXPECT_EQ(fits[0].law.kind, Law::Kind::kGent);
  // at a stress of 2.5 E the body of nu = 0.499 is larger by 2 %, the one without volume change not
  EXPECT_NEAR(fits[0].law.shape, limit, 0.06 * limit);
  EXPECT_NEAR(fits[0].young, 3 * mu, 0.02 * 3 * mu);
  // StVK has no equilibrium there, and the neo-Hookean law no upturn
  const TestFit stvk = fit_test({Law::kStvk}, 0.499, points);
  ASSERT_TRUE(stvk.impossible);
  EXPECT_EQ(stvk.error, std::numeric_limits<double>::infinity());
  EXPECT_LT(fits[0].error, 0.01);
  EXPECT_GT(fit_test({Law::kNeoHookean}, 0.499, points).error, 0.05);
}

TEST(MaterialTest, StaysWithinTheNoise) {
  std::vector<TestPoint> points = ogden_points(0.45, 5);
  double size = 0;
  for (const TestPoint& point : points) size += point.stress * point.stress;
  size = std::sqrt(size / double(points.size()));
  std::mt19937_64 random(11);
  std::normal_distribution<double> normal(0, 0.01 * size);
  for (TestPoint& point : points) point.stress += normal(random);
  const TestFit fit = fit_test({Law::ogden(2), true}, 0.45, points);
  // two numbers are fitted to 38 points
  EXPECT_NEAR(fit.error, 0.01 * std::sqrt(36.0 / 38), 0.003);
  EXPECT_NEAR(fit.young, kYoung, 0.02 * kYoung);
  EXPECT_NEAR(fit.law.shape, 5, 0.3);
  EXPECT_GT(fit.worst_error, fit.error);
  const TestPoint& worst = points[fit.worst];
  EXPECT_NEAR(std::abs(fit.stress[fit.worst] - worst.stress) / size, fit.worst_error, 1e-3);
}

TEST(MaterialTest, SaysWhereTheShapeIsAtAnEnd) {
  // the points harden less than Mooney and Rivlin's law can: r = 0
  const TestFit fit = fit_test({Law::mooney_rivlin(0), true}, 0.4, ogden_points(0.4, 6));
  EXPECT_TRUE(fit.at_end);
  EXPECT_EQ(fit.law.shape, 0);
}

TEST(MaterialTest, CountsPointsBeyondTheBoxOfNets) {
  // sides go with -nu e and -2 nu/(1 - nu) e; the box ends at 0.9 and at a volume of 2
  const std::vector<TestPoint> points = {{LoadPath::kUniaxial, std::exp(0.8), 1},
                                         {LoadPath::kUniaxial, std::exp(1.0), 1},
                                         {LoadPath::kBiaxial, std::exp(0.3), 1},
                                         {LoadPath::kBiaxial, std::exp(0.5), 1}};
  EXPECT_EQ(points_outside(Law::kHencky, 0.49, points), 2);
  EXPECT_EQ(points_outside(Law::kHencky, 0, points), 3);  // volumes e^0.8, e^1 and e^1
}

TEST(MaterialTest, KnowsEveryLaw) {
  EXPECT_EQ(test_laws().size(), law_names().size());
  for (const TestLaw& law : test_laws()) {
    // the range of the search is that of law_from_name
    const std::string name = law_name(law.law), bare = name.substr(0, name.find('='));
    EXPECT_EQ(test_law(bare).law.kind, law.law.kind);
    EXPECT_EQ(test_law(bare).family, law.family) << name;
    EXPECT_FALSE(test_law(name).family);
  }
  EXPECT_EQ(test_law("ogden=4").law, Law::ogden(4));
  EXPECT_THROW(test_law("rubber"), Error);
  EXPECT_THROW(test_law("gent=x"), Error);
}

TEST(MaterialTest, GivesTheSameBitsWithOneThread) {
  const std::vector<TestPoint> points = ogden_points(0.45, 5);
  std::vector<TestPoint> many;
  for (int k = 0; k < 10; ++k) many.insert(many.end(), points.begin(), points.end());
  const TestFit all = fit_test({Law::gent(2), true}, 0.45, many);
  const ThreadLimit one(1);
  const TestFit alone = fit_test({Law::gent(2), true}, 0.45, many);
  EXPECT_EQ(alone.law, all.law);
  EXPECT_EQ(alone.young, all.young);
  EXPECT_EQ(alone.error, all.error);
}

TEST(MaterialTest, RejectsWhatItsDocumentationForbids) {
  const std::vector<TestPoint> points = hencky_points(0.3);
  EXPECT_THROW(fit_test({Law::kHencky}, 0.5, points), Error);
  EXPECT_THROW(fit_test({Law::kHencky}, -0.1, points), Error);
  EXPECT_THROW(fit_test({Law::kHencky}, 0.3, {points[0]}), Error);
  EXPECT_THROW(fit_test({Law::kHencky}, 0.3, {}), Error);
  std::vector<TestPoint> pressures = points;
  for (TestPoint& point : pressures) point.stress = -point.stress;
  try {
    fit_test({Law::kHencky}, 0.3, pressures);
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kAsset);
    EXPECT_NE(std::string(error.what()).find("positive in tension"), std::string::npos);
  }
}

TEST(MaterialTest, ReadsColumnsInAnyOrderAndUnit) {
  const auto points = read_material_test(
      "\xef\xbb\xbf# a strip\r\nstress [kPa], mode ,strain\r\n\r\n"
      "100, uniaxial, 0.1 # first\n-20,biaxial,-0.25\n3e2,shear,1\n",
      "t.csv");
  ASSERT_EQ(points.size(), 3u);
  EXPECT_EQ(points[0].path, LoadPath::kUniaxial);
  EXPECT_EQ(points[1].path, LoadPath::kBiaxial);
  EXPECT_EQ(points[2].path, LoadPath::kShear);
  EXPECT_DOUBLE_EQ(points[0].stretch, 1.1);
  EXPECT_DOUBLE_EQ(points[1].stretch, 0.75);
  EXPECT_DOUBLE_EQ(points[2].stress, 3e5);
  EXPECT_EQ(points[0].line, 4);
  EXPECT_EQ(points[2].line, 6);
  const auto plain = read_material_test("stretch,stress\n1,0\n1.5,2\n2,3\n", "t.csv");
  EXPECT_EQ(plain[2].stress, 3);
  EXPECT_EQ(plain[2].stretch, 2);
  EXPECT_EQ(plain[2].path, LoadPath::kUniaxial);
  EXPECT_EQ(read_material_test("stretch,stress [MPa]\n1.5,2\n2,3", "t.csv")[0].stress, 2e6);
}

TEST(MaterialTest, TakesTwentyThousandPointsAndNoMore) {
  std::string text = "stretch,stress\n";
  for (int k = 0; k < 20'000; ++k) text += "1.5,2\n";
  EXPECT_EQ(read_material_test(text, "t.csv").size(), 20'000u);
  EXPECT_THROW(read_material_test(text + "1.5,2\n", "t.csv"), Error);
}

/// The message with which a test is refused.
std::string message(const std::string& text) {
  try {
    read_material_test(text, "t.csv");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kAsset);
    return error.what();
  }
  return "accepted";
}

TEST(MaterialTest, NamesLineAndColumnOfAnError) {
  // one fault each
  struct {
    const char *text, *place, *reason;
  } const kCases[] = {
      {"stretch,stress\n1.5,2\n2,x\n", "t.csv, line 3, column 2 (stress)", "'x' is not a number"},
      {"stretch,stress\n1.5,\n", "line 2", "expected 2 columns"},
      {"stretch,stress\n1.5,2,3\n", "line 2", "expected 2 columns, got 3"},
      {"stretch,stress\nnan,2\n", "line 2, column 1 (stretch)", "finite"},
      {"stretch,stress\n1.5,inf\n", "line 2, column 2 (stress)", "finite"},
      {"stretch,stress\n0,2\n", "line 2, column 1 (stretch)", "between 0.02 and 50"},
      {"strain,stress\n-1,2\n", "line 2, column 1 (strain)", "between"},
      {"strain,stress\n120,2\n", "line 2, column 1 (strain)", "no percentage"},
      {"mode,stretch,stress\ntorsion,2,2\n", "line 2, column 1 (mode)", "unknown mode 'torsion'"},
      {"# c\nstretch,force\n2,2\n", "line 2, column 2", "unknown column 'force'"},
      {"stretch,stress [N]\n2,2\n", "line 1, column 2", "N"},
      {"stretch [mm],stress\n2,2\n", "line 1, column 1", "belongs to stress"},
      {"stretch,stress [Pa\n2,2\n", "line 1, column 2", "belongs to stress"},
      {"stretch\n2\n", "line 1", "must name one column"},
      {"stretch,strain,stress\n2,1,2\n", "line 1", "must name one column"},
      {"stretch,stress,stress\n2,1,2\n", "line 1", "must name one column"},
      {"", "t.csv", "needs a head line"},
      {"stretch,stress\n", "t.csv", "at least two points"},
      {"stretch,stress\n1,0\n1.2,1\n", "t.csv", "has 1 such points"},
      {"stretch,stress\n1.1,0\n1.2,0\n", "t.csv", "stresses other than 0"}};
  for (const auto& c : kCases) {
    const std::string said = message(c.text);
    EXPECT_NE(said.find(c.place), std::string::npos) << said;
    EXPECT_NE(said.find(c.reason), std::string::npos) << said;
  }
}

}  // namespace
}  // namespace elastogen
