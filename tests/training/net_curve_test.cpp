// SPDX-License-Identifier: Apache-2.0
#include "training/net_curve.hpp"

#include "core/error.hpp"
#include "training/fit_neural_mtl.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

constexpr LoadPath kCurvePaths[] = {LoadPath::kUniaxial, LoadPath::kBiaxial, LoadPath::kShear,
                                    LoadPath::kVolume};

/// Weights whose last layer is 0: Hencky's law to the rounding of doubles.
std::vector<float> hencky_net() {
  std::vector<float> weights = initial_weights(3);
  std::fill(weights.end() - kMtlLast, weights.end(), 0.0f);
  return weights;
}

TEST(NetCurve, FindsNoErrorInTheNetThatIsHenckysLaw) {
  for (const LoadPath path : kCurvePaths) {
    const NetCurve curve = net_curve(fit_material("hencky", 0.45), hencky_net(), path);
    ASSERT_EQ(curve.stretch.size(), 161u);
    for (size_t k = 0; k < curve.stretch.size(); ++k) {
      EXPECT_LT(curve.stress_error[k], 1e-9);
      EXPECT_LT(curve.tangent_error[k], 1e-9);
      EXPECT_LT(curve.energy_error[k], 1e-9);
      EXPECT_NEAR(curve.net_stress[k], curve.law_stress[k], 1e-12);
      EXPECT_NEAR(curve.net_energy[k], curve.law_energy[k], 1e-12);
    }
  }
}

TEST(NetCurve, StatesTheDifferenceBetweenHenckysLawAndAnother) {
  // the net is Hencky's law, whose stress and energy follow from the stretches of the other law;
  // with nu = 0 no law moves its sides, and M = 1
  const NetCurve curve = net_curve(fit_material("stvk", 0), hencky_net(), LoadPath::kUniaxial);
  for (size_t k = 0; k < curve.stretch.size(); ++k) {
    const double l = curve.stretch[k], hencky = std::log(l) / l, stvk = l * (l * l - 1) / 2;
    EXPECT_NEAR(curve.net_stress[k], hencky, 1e-12);
    EXPECT_NEAR(curve.law_stress[k], stvk, 1e-12);
    EXPECT_NEAR(curve.stress_error[k], std::abs(hencky - stvk) / (std::abs(stvk) + 1e-4), 1e-9);
    const double green = (l * l - 1) / 2, psi = green * green / 2;
    EXPECT_NEAR(curve.energy_error[k], std::abs(std::pow(std::log(l), 2) / 2 - psi) / (psi + 1e-6),
                1e-9);
  }
}

TEST(NetCurve, EndsAtTheBox) {
  const auto ends = [](double nu, LoadPath path) {
    const NetCurve curve = net_curve(fit_material("hencky", nu), hencky_net(), path, 10);
    EXPECT_EQ(curve.stretch.size(), 21u);
    EXPECT_EQ(curve.stretch[10], 1);
    EXPECT_EQ(curve.law_stress[10], 0);
    EXPECT_NEAR(curve.stretch.front() * curve.stretch.back(), 1, 1e-9);
    return std::log(curve.stretch.back());
  };
  EXPECT_NEAR(ends(0.49, LoadPath::kUniaxial), 0.9, 1e-9);
  EXPECT_NEAR(ends(0.0, LoadPath::kUniaxial), std::log(2), 1e-9);
  EXPECT_NEAR(ends(0.3, LoadPath::kVolume), std::log(2) / 3, 1e-9);
  // the side has -2 nu/(1 - nu) e
  EXPECT_NEAR(ends(0.49, LoadPath::kBiaxial), 0.9 * 0.51 / 0.98, 1e-9);
}

TEST(NetCurve, RejectsWhatItsDocumentationForbids) {
  const FitMaterial material = fit_material("hencky", 0.3);
  EXPECT_THROW(net_curve(material, std::vector<float>(3), LoadPath::kShear), Error);
  EXPECT_THROW(net_curve(material, hencky_net(), LoadPath::kShear, 0), Error);
}

}  // namespace
}  // namespace elastogen
