// SPDX-License-Identifier: Apache-2.0
#include "training/last_layer_fit.hpp"

#include "core/error.hpp"
#include "core/parallel.hpp"
#include "core/tensor_file.hpp"
#include "io/safe_file.hpp"
#include "network/law/neural_mtl.hpp"
#include "training/fit_neural_mtl.hpp"
#include "training/fit_report.hpp"
#include "training/hidden_layers.hpp"
#include "training/law_targets.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace elastogen {
namespace {

LastLayerOptions few_strains() {
  LastLayerOptions options;
  options.strains = 60;
  return options;
}

/// Weights whose last layer is w.
std::vector<float> with_last(std::vector<float> weights, const std::vector<double>& w) {
  for (size_t k = 0; k < w.size(); ++k) weights[weights.size() - kMtlLast + k] = float(w[k]);
  return weights;
}

/// Numbers that floats hold.
std::vector<double> some_layer() {
  std::vector<double> w;
  for (int k = 0; k < kMtlLast - 1; ++k) w.push_back(double((37 * k) % 17 - 8) / 16);
  return w;
}

TEST(LastLayer, TakesTheStrainsOfTheNetAndTheirDerivatives) {
  constexpr int kRow[6] = {0, 1, 2, 0, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 0};
  constexpr double kStep = 1e-4;
  const FitMaterial material = fit_material("stvk", 0.3);
  const std::vector<float> start = initial_weights(3);
  const LastLayer layer(start, few_strains());
  const Array<double> q = layer.strains(material, some_layer());
  const NeuralMtl net(with_last(start, some_layer()), 0.3);
  // strains by NeuralMtl in double
  const auto value = [&](Vec3 e, int i) {
    double strains[3];
    net.strains(e.data(), 1, strains);
    return strains[i];
  };
  for (int64_t s = 0; s < 12; ++s) {
    const Vec3 e = {layer.points()(s, 0), layer.points()(s, 1), layer.points()(s, 2)};
    const auto moved = [&](int m, double a, int n, double b) {
      Vec3 to = e;
      to[m] += a, to[n] += b;
      return to;
    };
    // values, first and second central differences
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(q(s, i), value(e, i), 1e-13);
      for (int m = 0; m < 3; ++m) {
        const double difference =
            value(moved(m, kStep, m, 0), i) - value(moved(m, -kStep, m, 0), i);
        EXPECT_NEAR(q(s, 3 * (1 + m) + i), difference / (2 * kStep), 1e-6);
      }
      for (int c = 0; c < 6; ++c) {
        double sum = 0;
        for (const double a : {-kStep, kStep})
          for (const double b : {-kStep, kStep})
            sum += (a * b > 0 ? 1 : -1) * value(moved(kRow[c], a, kColumn[c], b), i);
        EXPECT_NEAR(q(s, 3 * (4 + c) + i), sum / (4 * kStep * kStep), 1e-5);
      }
    }
  }
}

/// The loss of weights at strains, by the jets of NeuralMtl.
double loss(const FitMaterial& material, const std::vector<float>& weights,
            const Array<double>& e) {
  constexpr int kRow[6] = {0, 1, 2, 0, 1, 2}, kColumn[6] = {0, 1, 2, 1, 2, 0};
  const double modulus = 2 * material.mu() + material.lambda();
  std::vector<LogJet> jets(size_t(e.rows()));
  NeuralMtl(weights, material.poisson).evaluate<true>(e.data(), e.rows(), jets.data());
  const TargetLaw law = target_law(material);
  double sum = 0;
  for (int64_t s = 0; s < e.rows(); ++s) {
    const LogJet& jet = jets[size_t(s)];
    const Response<double> r = target_response(law, e.row(s));
    // squares of the differences, and of the law's numbers
    double dt = 0, t = 0, dH = 0, H = 0;
    for (int m = 0; m < 3; ++m) {
      dt += std::pow(jet.w[m] * std::exp(-e(s, m)) - r.t[m], 2);
      t += r.t[m] * r.t[m];
    }
    for (int c = 0; c < 6; ++c) {
      const double h =
          (jet.ww[c] - (c < 3 ? jet.w[c] : 0)) * std::exp(-e(s, kRow[c]) - e(s, kColumn[c]));
      dH += (c < 3 ? 1 : 2) * std::pow(h - r.H[c], 2);
      H += (c < 3 ? 1 : 2) * r.H[c] * r.H[c];
    }
    // weights of the three errors
    sum += dt / std::pow(std::sqrt(t) + 1e-4 * modulus, 2) + 0.1 * dH / H +
           0.1 * std::pow((jet.psi - r.psi) / (r.psi + 1e-6 * modulus), 2);
  }
  return sum / double(e.rows());
}

TEST(LastLayer, StatesTheErrorOfTheFormulasAndLowersIt) {
  const FitMaterial material = fit_material("0.5*neo-hookean+0.5*stvk", 0.4);
  const std::vector<float> start = initial_weights(3);
  LastLayerOptions options = few_strains();
  options.iterations = 12;
  const LastLayer layer(start, options);
  const LastLayerFit early = layer.fit(material);
  EXPECT_EQ(early.iterations, 12);
  EXPECT_NEAR(early.error, std::sqrt(loss(material, early.weights, layer.points())),
              1e-5 * early.error);
  EXPECT_TRUE(std::equal(start.begin(), start.end() - kMtlLast, early.weights.begin()));
  const double before =
      std::sqrt(loss(material, with_last(start, std::vector<double>(kMtlLast)), layer.points()));
  EXPECT_LT(early.error, 0.2 * before);
}

TEST(LastLayer, FindsHenckysLawAtZero) {
  const LastLayerFit fit =
      LastLayer(initial_weights(3), few_strains()).fit(fit_material("hencky", 0.45));
  EXPECT_LT(fit.error, 1e-12);
  EXPECT_TRUE(std::all_of(fit.weights.end() - kMtlLast, fit.weights.end(),
                          [](float w) { return std::abs(w) < 1e-6f; }));
}

TEST(LastLayer, KeepsTheLimitsUpToIncompressibility) {
  const LastLayer layer(initial_weights(3));
  for (const FitMaterial& material : {fit_material("neo-hookean", 0.3), fit_material("stvk", 0.495),
                                      fit_material("0.4*fixed-corotated+0.6*neo-hookean", 0.48)}) {
    const LastLayerFit fit = layer.fit(material);
    const FitReport report = fit_report(material, fit.weights);
    EXPECT_TRUE(report.passes()) << material.name << ": " << report.stress_median << " "
                                 << report.stress_p99 << " " << report.stress_max << " "
                                 << report.tangent_p99;
    RecordProperty(material.name, std::to_string(report.stress_p99));
  }
}

std::vector<float> shipped_layers(const FitMaterial& material) {
  const std::string path = std::string(ELASTOGEN_SHIPPED_WEIGHTS "/") + hidden_layers_of(material);
  return decode_tensors(read_file(path, 1 << 20), path).get("neural_mtl", {kMtlParameters}).values;
}

// The first is one of three random sums that no start brings inside the limits on hidden.tensors;
// the next two are among those that the layers were trained on.
TEST(LastLayer, KeepsTheLimitsOfStiffSumsOnLayersOfTheirOwn) {
  for (const auto& [law, poisson] :
       {std::pair("0.5218*neo-hookean+0.4782*stvk", 0.491),
        std::pair("0.4*stvk+0.3*fixed-corotated+0.3*neo-hookean", 0.4935),
        std::pair("0.6*stvk+0.4*hencky", 0.495), std::pair("0.35*hencky+0.65*stvk", 0.495)}) {
    const FitMaterial material = fit_material(law, poisson);
    ASSERT_STREQ(hidden_layers_of(material), kSumHiddenLayers);
    const std::vector<float> layers = shipped_layers(material);
    const FitReport report = fit_report(material, LastLayer(layers).fit(material).weights);
    EXPECT_TRUE(report.passes()) << law << ": " << report.stress_median << " " << report.stress_p99
                                 << " " << report.stress_max << " " << report.tangent_p99;
  }
}

TEST(HiddenLayers, AreTheOnesOfMostMaterialsUnlessTheLawIsSteep) {
  EXPECT_STREQ(hidden_layers_of(fit_material("stvk", 0.495)), kHiddenLayers);
  EXPECT_STREQ(hidden_layers_of(fit_material("0.5*stvk+0.5*hencky", 0.48)), kHiddenLayers);
  EXPECT_STREQ(hidden_layers_of(fit_material("0.5*neo-hookean+0.5*hencky", 0.49)), kHiddenLayers);
  EXPECT_STREQ(hidden_layers_of(fit_material("0.5*stvk+0.5*hencky", 0.481)), kSumHiddenLayers);
  EXPECT_STREQ(hidden_layers_of(fit_material("0.5*stvk+0.5*gent=9", 0.49)), kGentHiddenLayers);
  EXPECT_STREQ(hidden_layers_of(fit_material("gent=12", 0.3)), kHiddenLayers);
}

TEST(LastLayer, GoesOnFromAStart) {
  const FitMaterial material = fit_material("stvk", 0.4);
  LastLayerOptions options;
  options.strains = 400;
  options.iterations = 10;
  const LastLayer layer(initial_weights(3), options);
  const LastLayerFit first = layer.fit(material);
  const std::span<const float> w = std::span(first.weights).last(kMtlLast).first(kMtlLast - 1);
  EXPECT_LT(layer.fit(material, w).error, first.error);
}

TEST(LastLayer, TellsItsWatchEachIteration) {
  const FitMaterial material = fit_material("stvk", 0.4);
  LastLayerOptions options = few_strains();
  options.iterations = 6;
  const LastLayer layer(initial_weights(3), options);
  std::vector<int> told;
  std::vector<float> last;
  const LastLayerFit fit = layer.fit(material, {}, [&](int done, std::span<const double> w) {
    told.push_back(done);
    last.assign(w.begin(), w.end());
  });
  EXPECT_EQ(told, (std::vector<int>{1, 2, 3, 4, 5, 6}));
  EXPECT_TRUE(std::equal(last.begin(), last.end(), fit.weights.end() - kMtlLast));
}

/// Stresses of weights at strains, (strains, 3), over |t| + 1e-4 M.
std::vector<double> scaled_stresses(const FitMaterial& material, const std::vector<float>& weights,
                                    const Array<double>& e) {
  std::vector<LogJet> jets(size_t(e.rows()));
  NeuralMtl(weights, material.poisson).evaluate<true>(e.data(), e.rows(), jets.data());
  const TargetLaw law = target_law(material);
  std::vector<double> scaled;
  for (int64_t s = 0; s < e.rows(); ++s) {
    const Response<double> r = target_response(law, e.row(s));
    const double size = std::sqrt(r.t[0] * r.t[0] + r.t[1] * r.t[1] + r.t[2] * r.t[2]) +
                        1e-4 * (2 * material.mu() + material.lambda());
    for (int m = 0; m < 3; ++m) scaled.push_back(jets[size_t(s)].w[m] * std::exp(-e(s, m)) / size);
  }
  return scaled;
}

TEST(LastLayer, MeasuresSmallChangesByTheChangeOfTheStress) {
  const FitMaterial material = fit_material("0.5*stvk+0.5*neo-hookean", 0.4);
  const std::vector<float> start = initial_weights(3);
  const LastLayer layer(start, few_strains());
  const std::vector<double> w = some_layer();
  const Array<double> metric = layer.stress_metric(material, w);
  for (uint64_t direction = 0; direction < 3; ++direction) {
    // steps that floats hold, so that the two nets differ by exactly them
    std::vector<double> dw, ahead = w, behind = w;
    for (size_t k = 0; k < w.size(); ++k) {
      dw.push_back(double((7 * k + direction * 11) % 13) / 4096 - 6.0 / 4096);
      ahead[k] += dw[k], behind[k] -= dw[k];
    }
    double predicted = 0, measured = 0;
    for (int i = 0; i < 128; ++i)
      for (int j = 0; j < 128; ++j) {
        predicted += dw[size_t(i)] * metric(i, j) * dw[size_t(j)];
        EXPECT_EQ(metric(i, j), metric(j, i));
      }
    // stresses are quadratic in w: the central difference is their derivative
    const std::vector<double> a = scaled_stresses(material, with_last(start, ahead),
                                                  layer.points()),
                              b = scaled_stresses(material, with_last(start, behind),
                                                  layer.points());
    for (size_t k = 0; k < a.size(); ++k)
      measured += std::pow((a[k] - b[k]) / 2, 2) / double(layer.points().rows());
    EXPECT_NEAR(predicted, measured, 1e-9 * measured);
  }
  EXPECT_THROW(layer.stress_metric(material, std::vector<double>(3)), Error);
}

TEST(LastLayer, GivesTheSameBitsWithOneThread) {
  const FitMaterial material = fit_material("stvk", 0.3);
  LastLayerOptions options = few_strains();
  options.strains = 300;
  const LastLayerFit all = LastLayer(initial_weights(3), options).fit(material);
  const ThreadLimit one(1);
  EXPECT_EQ(LastLayer(initial_weights(3), options).fit(material).weights, all.weights);
}

TEST(LastLayer, RejectsWhatItsDocumentationForbids) {
  EXPECT_THROW(LastLayer(std::vector<float>(3)), Error);
  LastLayerOptions none;
  none.strains = 0;
  EXPECT_THROW(LastLayer(initial_weights(3), none), Error);
  const LastLayer layer(initial_weights(3), few_strains());
  const std::vector<float> start(5);
  EXPECT_THROW(layer.fit(fit_material("stvk", 0.3), start), Error);
}

}  // namespace
}  // namespace elastogen
