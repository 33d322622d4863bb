// SPDX-License-Identifier: Apache-2.0
#include "diffusion/start_fit.hpp"

#include "core/error.hpp"
#include "tests/diffusion/dataset.hpp"

#include <gtest/gtest.h>

namespace elastogen {
namespace {

LastLayerOptions few_strains(int iterations) {
  LastLayerOptions options;
  options.strains = 64;
  options.iterations = iterations;
  return options;
}

TEST(StartFit, ReportsTheNetsOfFitsThatEndThere) {
  const std::vector<float> hidden = test::some_hidden();
  const FitMaterial material = fit_material("stvk", 0.3);
  ReportOptions judged;
  judged.strains = 128;
  const std::vector<float> start(128, 0.01f);
  constexpr int kIterations[] = {0, 2, 5, 200};
  // one fit, reported after 0, 2, 5 and more iterations than it makes
  const std::vector<StartFit> fits =
      fit_from(LastLayer(hidden, few_strains(12)), hidden, material, start, kIterations, judged);
  ASSERT_EQ(fits.size(), 4u);
  EXPECT_EQ(fits[0].layer, start);
  // each report is that of a fit that ends there
  for (size_t k = 0; k < 4; ++k) {
    std::vector<float> weights = hidden;
    std::copy(start.begin(), start.end(), weights.end() - kMtlLast);
    if (k > 0) {  // the last ends after the twelve that the fit allows
      const int iterations = std::min(kIterations[k], 12);
      weights = LastLayer(hidden, few_strains(iterations)).fit(material, start).weights;
    }
    EXPECT_TRUE(std::equal(fits[k].layer.begin(), fits[k].layer.end(), weights.end() - kMtlLast));
    EXPECT_EQ(fits[k].report.stress_p99, fit_report(material, weights, judged).stress_p99);
    EXPECT_EQ(fits[k].iterations, kIterations[k]);
  }
  EXPECT_LT(fits[3].report.stress_median, 0.1 * fits[0].report.stress_median);
  EXPECT_GE(fits[2].fit_seconds, fits[1].fit_seconds);
}

TEST(StartFit, RejectsIterationsThatDoNotAscendFromZero) {
  const std::vector<float> hidden = test::some_hidden(), start(128);
  const LastLayer layer(hidden, few_strains(5));
  const FitMaterial material = fit_material("stvk", 0.3);
  for (const std::vector<int>& iterations : {std::vector<int>{}, {1, 2}, {0, 3, 2}})
    EXPECT_THROW(fit_from(layer, hidden, material, start, iterations, {}), Error);
  const std::vector<int> fine = {0, 1};
  EXPECT_THROW(fit_from(layer, hidden, material, std::vector<float>(3), fine, {}), Error);
}

}  // namespace
}  // namespace elastogen
