// SPDX-License-Identifier: Apache-2.0
#include "diffusion/denoiser.hpp"

#include "core/error.hpp"
#include "diffusion/double_tensors.hpp"

#include <Eigen/Core>

#include <algorithm>
#include <cmath>

namespace elastogen {
namespace {

constexpr int kWidest = 4096;

std::string name_of(const char* part, int layer) {
  return concat("denoiser.", part, layer + 1);
}

}  // namespace

std::vector<float> time_embedding(int t) {
  constexpr int kHalf = kTimeEmbedding / 2;
  std::vector<float> embedding(kTimeEmbedding);
  for (int k = 0; k < kHalf; ++k) {
    const double angle = t * std::pow(1e4, -double(k) / kHalf);
    embedding[size_t(k)] = float(std::sin(angle));
    embedding[size_t(kHalf + k)] = float(std::cos(angle));
  }
  return embedding;
}

FeatureScale feature_scale(In<double> features) {
  FeatureScale result;
  for (int k = 0; k < features.cols; ++k) {
    double mean = 0, square = 0;
    for (int64_t n = 0; n < features.rows; ++n) mean += features(n, k) / double(features.rows);
    for (int64_t n = 0; n < features.rows; ++n)
      square += std::pow(features(n, k) - mean, 2) / double(features.rows);
    const double scale = std::sqrt(square);
    result.mean.push_back(float(mean));
    result.scale.push_back(scale > 1e-6 ? float(scale) : 1);
  }
  return result;
}

Denoiser::Denoiser(const DenoiserSizes& sizes, Layers layers, FeatureScale scale)
    : sizes_(sizes), layers_(std::move(layers)), scale_(std::move(scale)) {
  ELASTOGEN_CHECK(
      int(scale_.mean.size()) == sizes.features && int(scale_.scale.size()) == sizes.features,
      "the denoiser needs the scales of ", sizes.features, " features");
  for (int k = 0; k < kDenoiserLayers; ++k) {
    const Layer& layer = layers_[size_t(k)];
    ELASTOGEN_CHECK(int64_t(layer.W.size()) == int64_t(sizes.rows(k)) * sizes.columns(k) &&
                        int64_t(layer.b.size()) == sizes.rows(k),
                    "layer ", k + 1, " of the denoiser must be (", sizes.rows(k), ", ",
                    sizes.columns(k), "), it has ", layer.W.size(), " weights");
  }
}

Denoiser::Denoiser(const TensorFile& file, int code, int features) {
  sizes_ = {code, features, int(get_count(file, "denoiser.width", 1, kWidest))};
  for (int k = 0; k < kDenoiserLayers; ++k)
    layers_[size_t(k)] = {file.get(name_of("W", k), {sizes_.rows(k), sizes_.columns(k)}).values,
                          file.get(name_of("b", k), {sizes_.rows(k)}).values};
  scale_ = {file.get("denoiser.mean", {features}).values,
            file.get("denoiser.scale", {features}).values};
  ELASTOGEN_CHECK_ASSET(
      std::all_of(scale_.scale.begin(), scale_.scale.end(), [](float s) { return s > 0; }),
      "'denoiser.scale' has a number that is not positive");
}

void Denoiser::write(TensorFile& file) const {
  file.text["denoiser.width"] = std::to_string(sizes_.width);
  file.tensors.push_back({"denoiser.mean", {sizes_.features}, scale_.mean});
  file.tensors.push_back({"denoiser.scale", {sizes_.features}, scale_.scale});
  for (int k = 0; k < kDenoiserLayers; ++k) {
    const Layer& layer = layers_[size_t(k)];
    file.tensors.push_back({name_of("W", k), {sizes_.rows(k), sizes_.columns(k)}, layer.W});
    file.tensors.push_back({name_of("b", k), {sizes_.rows(k)}, layer.b});
  }
}

std::vector<float> Denoiser::x0(std::span<const float> x, int t,
                                std::span<const float> features) const {
  ELASTOGEN_CHECK(int(x.size()) == sizes_.code && int(features.size()) == sizes_.features,
                  "a denoiser takes ", sizes_.code, " numbers and ", sizes_.features,
                  " features, not ", x.size(), " and ", features.size());
  std::vector<float> values(x.begin(), x.end());
  const std::vector<float> embedding = time_embedding(t);
  values.insert(values.end(), embedding.begin(), embedding.end());
  for (size_t k = 0; k < features.size(); ++k)
    values.push_back((features[k] - scale_.mean[k]) / scale_.scale[k]);
  using Rows = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
  Eigen::VectorXf a = Eigen::Map<const Eigen::VectorXf>(values.data(), sizes_.inputs());
  for (int k = 0; k < kDenoiserLayers; ++k) {
    const Layer& layer = layers_[size_t(k)];
    const Eigen::Map<const Rows> W(layer.W.data(), sizes_.rows(k), sizes_.columns(k));
    Eigen::VectorXf z = W * a + Eigen::Map<const Eigen::VectorXf>(layer.b.data(), sizes_.rows(k));
    if (k + 1 < kDenoiserLayers) z.array() /= 1 + (-z.array()).exp();
    a = std::move(z);
  }
  return {a.data(), a.data() + a.size()};
}

}  // namespace elastogen
