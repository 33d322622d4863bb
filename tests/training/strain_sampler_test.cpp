// SPDX-License-Identifier: Apache-2.0
#include "training/strain_sampler.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

double radius(const double* e) {
  return std::sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]);
}

TEST(StrainSampler, StaysInTheBox) {
  for (const StrainBox& box : {kDeclaredBox, kFitBox}) {
    const Array<double> e = sample_strains(box, 3, 0, 20000);
    for (int64_t s = 0; s < e.rows(); ++s) {
      for (int i = 0; i < 3; ++i) EXPECT_LE(std::abs(e(s, i)), box.stretch);
      EXPECT_LE(std::abs(e(s, 0) + e(s, 1) + e(s, 2)), box.volume * (1 + 1e-14));
    }
  }
}

TEST(StrainSampler, EndsAtNineTenthsOfTheLeastLimit) {
  const FitMaterial steep = fit_material("0.5*gent=20+0.25*gent=4+0.25*hencky", 0.3),
                    mild = fit_material("gent=60", 0.3), none = fit_material("stvk", 0.3);
  EXPECT_DOUBLE_EQ(declared_box(steep).invariant, 3.6);
  EXPECT_DOUBLE_EQ(fit_box({&mild, 1}).invariant, 54);
  EXPECT_DOUBLE_EQ(fit_box(std::vector{mild, steep, none}).invariant, 3.6);
  EXPECT_TRUE(std::isinf(declared_box(none).invariant));
  const Array<double> e = sample_strains(declared_box(steep), 3, 0, 20000);
  double largest = 0;
  for (int64_t s = 0; s < e.rows(); ++s) {
    const double mean = (e(s, 0) + e(s, 1) + e(s, 2)) / 3;
    double excess = -3;
    for (int i = 0; i < 3; ++i) excess += std::exp(2 * (e(s, i) - mean));
    largest = std::max(largest, excess);
  }
  EXPECT_LE(largest, 3.6);
  EXPECT_GT(largest, 3.5);
  // a limit far beyond the box changes no strain
  EXPECT_EQ(sample_strains(declared_box(mild), 3, 0, 500), sample_strains(kDeclaredBox, 3, 0, 500));
}

TEST(StrainSampler, DrawsAnyPartOfASequenceAgain) {
  const Array<double> all = sample_strains(kFitBox, 5, 0, 100);
  const Array<double> part = sample_strains(kFitBox, 5, 37, 20);
  for (int64_t s = 0; s < 20; ++s)
    for (int i = 0; i < 3; ++i) EXPECT_EQ(part(s, i), all(37 + s, i));
  EXPECT_NE(sample_strains(kFitBox, 6, 0, 100), all);
}

TEST(StrainSampler, SpreadsRadiiOfSpheresEvenlyInTheirLogarithm) {
  const int64_t count = 40000;
  const Array<double> e = sample_strains(kFitBox, 1, 0, count);
  int64_t decade[4] = {};
  for (int64_t s = 1; s < count; s += 2) {
    const double r = radius(e.row(s));
    EXPECT_GE(r, 0.99e-4);
    ++decade[std::clamp(int(std::floor(std::log10(r))) + 4, 0, 3)];
  }
  // binomial: 20000 / 4, five standard deviations are 306
  for (const int64_t n : decade) EXPECT_NEAR(double(n), 5000, 306);
}

TEST(StrainSampler, FavoursNoAxisAndNoSign) {
  const int64_t count = 40000;
  const Array<double> e = sample_strains(kDeclaredBox, 2, 0, count);
  for (int i = 0; i < 3; ++i) {
    double sum = 0;
    for (int64_t s = 0; s < count; ++s) sum += e(s, i);
    // the standard deviation of a component is below 0.52
    EXPECT_NEAR(sum / double(count), 0, 5 * 0.52 / std::sqrt(double(count)));
  }
}

TEST(StrainSampler, ReachesTheEndsOfTheTrace) {
  const Array<double> e = sample_strains(kDeclaredBox, 2, 0, 1000);
  double lowest = 0, highest = 0;
  for (int64_t s = 0; s < 1000; ++s) {
    const double trace = e(s, 0) + e(s, 1) + e(s, 2);
    lowest = std::min(lowest, trace), highest = std::max(highest, trace);
  }
  EXPECT_NEAR(lowest, -kDeclaredBox.volume, 1e-14);
  EXPECT_NEAR(highest, kDeclaredBox.volume, 1e-14);
}

TEST(StrainSampler, TakesNoStrains) {
  EXPECT_TRUE(sample_strains(kFitBox, 1, 0, 0).empty());
}

}  // namespace
}  // namespace elastogen
