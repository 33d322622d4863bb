// SPDX-License-Identifier: Apache-2.0
#include "diffusion/generate_weights.hpp"

#include "core/error.hpp"
#include "diffusion/hidden_hash.hpp"
#include "tests/diffusion/dataset.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

namespace elastogen {
namespace {

constexpr int kNetWidth = 128, kCount = 30, kComponents = 6;
constexpr Start kGenerated[] = {Start::kNearest, Start::kInterpolation, Start::kRegression};

/// Last layers of 1-D families: f_k(s) with s the 13th feature, so that they lie in few components.
WeightDataset smooth_dataset() {
  WeightDataset data = test::some_dataset(kCount);
  for (int64_t n = 0; n < kCount; ++n)
    for (int k = 0; k < kNetWidth; ++k)
      data.layers(n, k) = float(std::sin(k + 2 * data.features(n, 12)) + 0.1 * data.features(n, 8));
  return data;
}

WeightCodec some_codec(const WeightDataset& data) {
  Array<double> metric(kNetWidth, kNetWidth);
  for (int k = 0; k < kNetWidth; ++k) metric(k, k) = 1 + 0.01 * k;
  return {data.layers, metric, kComponents};
}

/// A denoiser that returns b for any input.
Denoiser constant_denoiser(const std::vector<float>& b) {
  const DenoiserSizes sizes{kComponents, kMaterialFeatures, 4};
  Denoiser::Layers layers;
  for (int k = 0; k < kDenoiserLayers; ++k) {
    layers[size_t(k)].W.resize(size_t(sizes.rows(k) * sizes.columns(k)));
    layers[size_t(k)].b.resize(size_t(sizes.rows(k)));
  }
  layers[3].b = b;
  return {sizes,
          std::move(layers),
          {std::vector<float>(kMaterialFeatures), std::vector<float>(kMaterialFeatures, 1)}};
}

WeightGenerator with_denoiser(const std::vector<float>& b) {
  const WeightDataset data = smooth_dataset();
  const WeightCodec codec = some_codec(data);
  const Array<double> codes = codec.encode(data.layers);
  return WeightGenerator({hidden_hash(data.hidden), codec, WeightRegression(data.features, codes),
                          codes, constant_denoiser(b)});
}

double difference(const std::vector<float>& a, const float* b) {
  double most = 0;
  for (size_t k = 0; k < a.size(); ++k) most = std::max(most, double(std::abs(a[k] - b[k])));
  return most;
}

TEST(WeightGenerator, GivesAKnownMaterialItsLayer) {
  const WeightDataset data = smooth_dataset();
  const WeightGenerator generator = make_generator(data, some_codec(data));
  EXPECT_EQ(generator.hidden(), hidden_hash(data.hidden));
  for (const Start start : kGenerated)
    for (const size_t n : {0, 7, 29})
      EXPECT_LT(
          difference(generator.last_layer(data.materials[n], start), data.layers.row(int64_t(n))),
          1e-4)
          << name_of(start);
}

TEST(WeightGenerator, BeginsAtZeroOrAtOneLayerForAll) {
  const WeightDataset data = smooth_dataset();
  const WeightGenerator generator = make_generator(data, some_codec(data));
  EXPECT_EQ(generator.last_layer(data.materials[4], Start::kZero), std::vector<float>(kNetWidth));
  const std::vector<float> ancestor = generator.last_layer(data.materials[4], Start::kAncestor);
  EXPECT_EQ(generator.last_layer(data.materials[9], Start::kAncestor), ancestor);
  // it is a known layer, and no other is nearer to the mean
  const Array<double> codes = generator.codec().encode(data.layers);
  double least = 1e30;
  int64_t nearest = -1;
  for (int64_t n = 0; n < kCount; ++n) {
    const double* const c = codes.row(n);
    const double size = std::inner_product(c, c + codes.cols(), c, 0.0);
    if (size < least) least = size, nearest = n;
  }
  EXPECT_LT(difference(ancestor, data.layers.row(nearest)), 1e-4);
}

TEST(WeightGenerator, InterpolatesBetterThanItTakesTheNearest) {
  const WeightDataset data = smooth_dataset();
  const WeightGenerator generator = make_generator(data, some_codec(data));
  double nearest = 0, regression = 0;
  for (uint64_t n = 100; n < 140; ++n) {
    const FitMaterial material = family_material(3, n);
    const std::vector<double> x = material_features(material);
    std::vector<float> exact;
    for (int k = 0; k < kNetWidth; ++k)
      exact.push_back(float(std::sin(k + 2 * x[12]) + 0.1 * x[8]));
    nearest += difference(generator.last_layer(material, Start::kNearest), exact.data());
    regression += difference(generator.last_layer(material, Start::kRegression), exact.data());
  }
  EXPECT_LT(regression, 0.5 * nearest);
}

TEST(WeightGenerator, ScalesWhatTheDiffusionEndsIn) {
  const std::vector<float> b = {1, -1, 0.5f, 0, 2, 0.25f};
  const WeightGenerator generator = with_denoiser(b);
  std::vector<double> code;
  for (size_t c = 0; c < b.size(); ++c) code.push_back(b[c] * generator.codec().scale()[c]);
  const std::vector<float> expected = generator.codec().decode(code);
  const std::vector<float> got =
      generator.last_layer(family_material(3, 50), Start::kDiffusion, 12);
  EXPECT_LT(difference(got, expected.data()), 1e-6);
}

TEST(WeightGenerator, IsTheSameFromAFile) {
  const WeightGenerator generator = with_denoiser(std::vector<float>(kComponents, 0.5f));
  const WeightGenerator again(decode_tensors(encode_tensors(generator.file()), "g"), "g");
  EXPECT_EQ(again.hidden(), generator.hidden());
  ASSERT_TRUE(again.has_denoiser());
  const FitMaterial material = family_material(3, 50);
  for (const Start start : kStarts)
    EXPECT_LT(
        difference(again.last_layer(material, start), generator.last_layer(material, start).data()),
        1e-6)
        << name_of(start);
}

/// The message that refuses a file; empty if it is accepted.
std::string refusal(const TensorFile& file) {
  try {
    WeightGenerator(file, "g.tensors");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), ErrorKind::kAsset) << error.what();
    EXPECT_EQ(std::string(error.what()).find("g.tensors: "), 0u) << error.what();
    return error.what();
  }
  return "";
}

TEST(WeightGenerator, RefusesFilesThatLackSomethingOrHaveItInAnotherShape) {
  const TensorFile whole = with_denoiser(std::vector<float>(kComponents)).file();
  ASSERT_EQ(refusal(whole), "");
  // each tensor: missing, or larger
  for (size_t k = 0; k < whole.tensors.size(); ++k) {
    TensorFile file = whole;
    file.tensors.erase(file.tensors.begin() + int64_t(k));
    EXPECT_NE(refusal(file), "") << whole.tensors[k].name;
    file = whole;
    file.tensors[k].shape[0] += 1;
    file.tensors[k].values.resize(file.tensors[k].values.size() * 2);
    EXPECT_NE(refusal(file), "") << whole.tensors[k].name;
  }
  // each text: with another value, or missing
  for (const auto& [name, value] : whole.text) {
    if (name == "generator.hidden") continue;
    for (const char* other : {"0", "-1", "7", "1000000000", "x", ""}) {
      TensorFile file = whole;
      file.text[name] = other;
      EXPECT_NE(refusal(file), "") << name << " = " << other;
    }
    TensorFile file = whole;
    file.text.erase(name);
    if (name != "denoiser.width") {  // without it there is none
      EXPECT_NE(refusal(file), "") << name;
    }
  }
}

TEST(WeightGenerator, RefusesScalesThatAreNotPositive) {
  const TensorFile whole = with_denoiser(std::vector<float>(kComponents)).file();
  for (const char* name : {"regression.lengths", "denoiser.scale", "codec.scale"}) {
    TensorFile file = whole;
    for (Tensor& tensor : file.tensors)
      if (tensor.name == name) tensor.values[1] = -1;
    EXPECT_NE(refusal(file), "") << name;
  }
}

TEST(WeightGenerator, RejectsPartsThatDoNotFitAndADiffusionWithoutDenoiser) {
  const WeightDataset data = smooth_dataset();
  const WeightCodec codec = some_codec(data);
  const Array<double> codes = codec.encode(data.layers);
  const WeightRegression regression(data.features, codes);
  EXPECT_THROW(WeightGenerator({"", codec, regression, Array<double>(3, kComponents), {}}), Error);
  EXPECT_THROW(WeightGenerator({"", codec, regression, Array<double>(kCount, 2), {}}), Error);
  const WeightGenerator generator = make_generator(data, codec);
  EXPECT_FALSE(generator.has_denoiser());
  EXPECT_THROW(generator.last_layer(data.materials[0], Start::kDiffusion), Error);
}

}  // namespace
}  // namespace elastogen
