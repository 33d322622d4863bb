// SPDX-License-Identifier: Apache-2.0
#include "diffusion/generate_weights.hpp"

#include "core/error.hpp"
#include "diffusion/hidden_hash.hpp"
#include "diffusion/sampler.hpp"

#include <algorithm>
#include <limits>
#include <numeric>

namespace elastogen {
namespace {

constexpr const char* kForm = "1";
constexpr int64_t kInterpolated = 8;
constexpr int kDdimSteps = 50;

void check_parts(const GeneratorParts& parts) {
  const int components = parts.codec.components();
  ELASTOGEN_CHECK(
      parts.codes.rows() == parts.regression.count() && parts.codes.cols() == components,
      "a generator needs ", parts.regression.count(), " codes of ", components, " numbers, got ",
      Span<const double>(parts.codes));
  ELASTOGEN_CHECK(!parts.denoiser || (parts.denoiser->sizes().code == components &&
                                      parts.denoiser->sizes().features == kMaterialFeatures),
                  "the denoiser is not of codes of ", components, " numbers");
}

GeneratorParts parts_of(const TensorFile& file) {
  const auto text = [&](const char* name) -> const std::string& {
    const auto found = file.text.find(name);
    ELASTOGEN_CHECK_ASSET(found != file.text.end(), "the file has no text '", name, "'");
    return found->second;
  };
  ELASTOGEN_CHECK_ASSET(text("generator.form") == kForm, "a generator of form '",
                        text("generator.form"), "', not '", kForm, "'");
  WeightCodec codec(file);
  const int components = codec.components();
  WeightRegression regression(file, components);
  const int64_t n = regression.count();
  const std::vector<float>& values = file.get("generator.codes", {n, components}).values;
  Array<double> codes(n, components);
  std::copy(values.begin(), values.end(), codes.data());
  std::optional<Denoiser> denoiser;
  if (file.text.contains("denoiser.width")) denoiser.emplace(file, components, kMaterialFeatures);
  return {text("generator.hidden"), std::move(codec), std::move(regression), std::move(codes),
          std::move(denoiser)};
}

GeneratorParts parts_of(const TensorFile& file, const std::string& place) {
  try {
    return parts_of(file);
  } catch (const Error& error) {
    throw Error(concat(place, ": ", error.what()), ErrorKind::kAsset);
  }
}

}  // namespace

const char* name_of(Start start) {
  switch (start) {
    case Start::kAncestor:
      return "ancestor";
    case Start::kNearest:
      return "nearest";
    case Start::kInterpolation:
      return "interpolation";
    case Start::kRegression:
      return "regression";
    case Start::kDiffusion:
      return "diffusion";
    default:
      return "zero";
  }
}

WeightGenerator::WeightGenerator(GeneratorParts parts) : parts_(std::move(parts)) {
  check_parts(parts_);
  for (int64_t k = 0; k < parts_.codes.size(); ++k)  // rounded as a file has them
    parts_.codes.data()[k] = float(parts_.codes.data()[k]);
}

WeightGenerator::WeightGenerator(const TensorFile& file, const std::string& place)
    : parts_(parts_of(file, place)) {}

TensorFile WeightGenerator::file() const {
  TensorFile file;
  file.text = {{"generator.form", kForm}, {"generator.hidden", parts_.hidden}};
  parts_.codec.write(file);
  parts_.regression.write(file);
  const Array<double>& codes = parts_.codes;
  file.tensors.push_back({"generator.codes",
                          {codes.rows(), codes.cols()},
                          {codes.data(), codes.data() + codes.size()}});
  if (parts_.denoiser) parts_.denoiser->write(file);
  return file;
}

std::vector<float> WeightGenerator::last_layer(const FitMaterial& material, Start start,
                                               uint64_t seed) const {
  if (start == Start::kZero) return std::vector<float>(kMtlWidthOfLast);
  return parts_.codec.decode(code(material_features(material), start, seed));
}

std::vector<double> WeightGenerator::code(const std::vector<double>& features, Start start,
                                          uint64_t seed) const {
  const Array<double>& codes = parts_.codes;
  switch (start) {
    case Start::kNearest:
      return mean_of_nearest(features, 1);
    case Start::kInterpolation:
      return mean_of_nearest(features, kInterpolated);
    case Start::kRegression:
      return parts_.regression.code(features.data());
    case Start::kDiffusion:
      return diffused(features, seed);
    default:
      break;
  }
  // the mean has the code 0, so the ancestor has the smallest code
  int64_t ancestor = 0;
  double least = std::numeric_limits<double>::infinity();
  for (int64_t n = 0; n < codes.rows(); ++n) {
    const double* const c = codes.row(n);
    const double size = std::inner_product(c, c + codes.cols(), c, 0.0);
    if (size < least) least = size, ancestor = n;
  }
  return {codes.row(ancestor), codes.row(ancestor) + codes.cols()};
}

std::vector<double> WeightGenerator::mean_of_nearest(const std::vector<double>& features,
                                                     int64_t count) const {
  const std::vector<double> squared = parts_.regression.distances(features.data());
  std::vector<int64_t> rows(squared.size());
  std::iota(rows.begin(), rows.end(), int64_t(0));
  count = std::min(count, int64_t(rows.size()));
  std::partial_sort(rows.begin(), rows.begin() + count, rows.end(), [&](int64_t a, int64_t b) {
    return std::pair(squared[size_t(a)], a) < std::pair(squared[size_t(b)], b);
  });
  std::vector<double> mean(size_t(parts_.codes.cols()));
  double sum = 0;
  for (int64_t k = 0; k < count; ++k) {
    const double weight = 1 / std::max(squared[size_t(rows[size_t(k)])], 1e-30);
    sum += weight;
    for (size_t c = 0; c < mean.size(); ++c)
      mean[c] += weight * parts_.codes(rows[size_t(k)], int(c));
  }
  for (double& value : mean) value /= sum;
  return mean;
}

std::vector<double> WeightGenerator::diffused(const std::vector<double>& features,
                                              uint64_t seed) const {
  ELASTOGEN_CHECK(parts_.denoiser,
                  "the generator has no denoiser; train one: "
                  "elastogen train diffusion");
  const std::vector<float> condition(features.begin(), features.end());
  const Denoise denoise = [&](std::span<const double> x, int t, std::span<double> x0) {
    const std::vector<float> result =
        parts_.denoiser->x0(std::vector<float>(x.begin(), x.end()), t, condition);
    std::copy(result.begin(), result.end(), x0.begin());
  };
  // diffusion works on components of variance 1
  std::vector<double> code =
      sample_ddim(denoise, parts_.codec.components(), seed, kDdimSteps, noise_schedule());
  for (size_t c = 0; c < code.size(); ++c) code[c] *= parts_.codec.scale()[c];
  return code;
}

WeightGenerator make_generator(const WeightDataset& data, const WeightCodec& codec) {
  Array<double> codes = codec.encode(data.layers);
  WeightRegression regression(data.features, codes);
  return WeightGenerator(
      {hidden_hash(data.hidden), codec, std::move(regression), std::move(codes), std::nullopt});
}

}  // namespace elastogen
