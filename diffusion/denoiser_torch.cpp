// SPDX-License-Identifier: Apache-2.0
#include "diffusion/denoiser_torch.hpp"

#include "core/error.hpp"
#include "core/hash.hpp"
#include "training/fit_problem_torch.hpp"

#include <ATen/ATen.h>
#include <ATen/core/grad_mode.h>

#include <cmath>

namespace elastogen {
namespace {

constexpr double kAverage = 0.999;
constexpr int kDdimSteps = 50;

/// Embeddings of the times 0 ... T, (T + 1, 64).
at::Tensor embeddings(at::Device device) {
  at::Tensor all = at::empty({kNoiseSteps + 1, kTimeEmbedding});
  for (int t = 0; t <= kNoiseSteps; ++t) {
    const std::vector<float> one = time_embedding(t);
    std::copy(one.begin(), one.end(), all[t].data_ptr<float>());
  }
  return all.to(device);
}

at::Tensor schedule_tensor(at::Device device) {
  const std::vector<double> A = noise_schedule();
  return at::tensor(A, at::kDouble).to(at::kFloat).to(device);
}

/// Features centred at their mean, divided by their scale.
at::Tensor standardised(In<double> features, const FeatureScale& scale, at::Device device) {
  const at::Tensor mean = at::tensor(scale.mean), size = at::tensor(scale.scale);
  return ((tensor_of(features, at::kCPU) - mean) / size).to(device);
}

/// A digest of numbers that identifies a checkpoint.
std::string digest(In<double> values) {
  return hex(
      sha256({reinterpret_cast<const char*>(values.data), size_t(values.size()) * sizeof(double)}));
}

LoopOptions loop_of(const DenoiserOptions& options, const char* kind, In<double> data,
                    In<double> features) {
  LoopOptions loop = options.loop;
  loop.average = kAverage;
  loop.identity = concat(kind, " width ", options.width, " steps ", loop.steps, " batch ",
                         options.batch, " rate ", loop.rate, " seed ", options.seed, " data ",
                         digest(data), " features ", digest(features));
  return loop;
}

/// Predicts x_0 from x_t, times and features of one batch.
using Predict = std::function<at::Tensor(const Parameters&, const at::Tensor& x,
                                         const at::Tensor& t, const at::Tensor& features)>;

/// The loss of a step: rows drawn with replacement, with a time and noise for each row.
StepLoss x0_loss(const at::Tensor& data, const at::Tensor& features, const Predict& predict,
                 const DenoiserOptions& options) {
  const at::Device device = data.device();
  const at::Tensor A = schedule_tensor(device);
  return [=](const Parameters& parameters, int64_t step) {
    at::Generator random = step_generator(options.seed, step);
    const at::Tensor rows = at::randint(0, data.size(0), {options.batch}, random, at::kLong);
    const at::Tensor times = at::randint(1, kNoiseSteps + 1, {options.batch}, random, at::kLong);
    const at::Tensor noise = at::randn({options.batch, data.size(1)}, random);
    const at::Tensor n = rows.to(device), t = times.to(device);
    const at::Tensor x0 = data.index_select(0, n), kept = A.index_select(0, t).unsqueeze(1);
    const at::Tensor x = kept.sqrt() * x0 + (1 - kept).sqrt() * noise.to(device);
    const at::Tensor miss = predict(parameters, x, t, features.index_select(0, n)) - x0;
    return (miss * miss).mean();
  };
}

void check_sizes(In<double> codes, In<double> features, const DenoiserOptions& options) {
  ELASTOGEN_CHECK(codes.rows > 0 && codes.cols > 0 && features.rows == codes.rows &&
                      options.batch > 0 && options.width > 0,
                  "a denoiser needs as many features as codes, a batch and a width, got ", codes,
                  ", ", features, ", ", options.batch, " and ", options.width);
}

}  // namespace

std::optional<Denoiser> train_denoiser(In<double> codes, In<double> features,
                                       const DenoiserOptions& options, const FitHooks& hooks) {
  check_sizes(codes, features, options);
  const at::Device device = fit_device(options.device);
  const DenoiserSizes sizes{codes.cols, features.cols, options.width};
  // random weights
  const FeatureScale scale = feature_scale(features);
  at::Generator random = step_generator(options.seed, -1);
  Parameters start;
  for (int k = 0; k < kDenoiserLayers; ++k)
    add_linear(start, sizes.rows(k), sizes.columns(k), random, device);
  // the net of the header, SiLU between its layers
  const at::Tensor of_time = embeddings(device);
  const Predict predict = [&](const Parameters& w, const at::Tensor& x, const at::Tensor& t,
                              const at::Tensor& f) {
    at::Tensor a = at::cat({x, of_time.index_select(0, t), f}, 1);
    for (size_t k = 0; k < kDenoiserLayers; ++k) {
      a = at::addmm(w[2 * k + 1], a, w[2 * k].t());
      if (k + 1 < kDenoiserLayers) a = at::silu(a);
    }
    return a;
  };
  // train
  const StepLoss loss =
      x0_loss(tensor_of(codes, device), standardised(features, scale, device), predict, options);
  const LoopOutcome outcome =
      train_loop(start, loss, loop_of(options, "denoiser", codes, features), hooks);
  if (outcome.steps < options.loop.steps) return std::nullopt;
  // the weights as floats, without libtorch
  Denoiser::Layers layers;
  for (size_t k = 0; k < kDenoiserLayers; ++k)
    layers[k] = {floats_of(outcome.parameters[2 * k]), floats_of(outcome.parameters[2 * k + 1])};
  return Denoiser(sizes, std::move(layers), scale);
}

ConvDenoiser::ConvDenoiser(int side, int channels, FeatureScale scale, uint64_t seed,
                           at::Device device)
    : side_(side), scale_(std::move(scale)), device_(device), of_time_(embeddings(device)) {
  ELASTOGEN_CHECK(side > 0 && channels > 0, "a convolutional denoiser needs a side and channels");
  at::Generator random = step_generator(seed, -1);
  const auto add_convolution = [&](int64_t to, int64_t from) {
    add_linear(parameters_, to, 9 * from, random, device);
    at::Tensor& W = parameters_[parameters_.size() - 2];
    W = W.view({to, from, 3, 3});
  };
  add_linear(parameters_, channels, kTimeEmbedding + int64_t(scale_.mean.size()), random, device);
  add_convolution(channels, 1);
  for (int k = 0; k < kBlocks; ++k) {
    add_convolution(channels, channels);
    add_linear(parameters_, channels, channels, random, device);
    add_convolution(channels, channels);
  }
  add_convolution(1, channels);
}

at::Tensor ConvDenoiser::x0(const Parameters& parameters, const at::Tensor& x, const at::Tensor& t,
                            const at::Tensor& features) const {
  size_t next = 0;
  const auto linear = [&](const at::Tensor& a) {
    next += 2;
    return at::addmm(parameters[next - 1], a, parameters[next - 2].t());
  };
  const auto convolution = [&](const at::Tensor& a) {
    next += 2;
    return at::conv2d(a, parameters[next - 2], parameters[next - 1], 1, 1);
  };
  const at::Tensor c = at::silu(linear(at::cat({of_time_.index_select(0, t), features}, 1)));
  at::Tensor h = convolution(x.reshape({x.size(0), 1, side_, side_}));
  for (int k = 0; k < kBlocks; ++k) {
    const at::Tensor inner = convolution(at::silu(h));
    h = h + convolution(at::silu(inner + linear(c).unsqueeze(2).unsqueeze(3)));
  }
  return convolution(at::silu(h)).reshape({x.size(0), int64_t(side_) * side_});
}

bool ConvDenoiser::train(In<double> images, In<double> features, const DenoiserOptions& options,
                         const FitHooks& hooks) {
  check_sizes(images, features, options);
  ELASTOGEN_CHECK(images.cols == side_ * side_, "images must have ", side_, " x ", side_,
                  " numbers, got ", images);
  const Predict predict = [this](const Parameters& w, const at::Tensor& x, const at::Tensor& t,
                                 const at::Tensor& f) { return x0(w, x, t, f); };
  const StepLoss loss = x0_loss(tensor_of(images, device_), standardised(features, scale_, device_),
                                predict, options);
  LoopOutcome outcome = train_loop(
      parameters_, loss, loop_of(options, "convolutional denoiser", images, features), hooks);
  if (outcome.steps < options.loop.steps) return false;
  parameters_ = std::move(outcome.parameters);
  return true;
}

void ConvDenoiser::write(TensorFile& file) const {
  file.text["convolution.side"] = std::to_string(side_);
  file.tensors.push_back({"convolution.features.mean", {int64_t(scale_.mean.size())}, scale_.mean});
  file.tensors.push_back(
      {"convolution.features.scale", {int64_t(scale_.scale.size())}, scale_.scale});
  for (size_t k = 0; k < parameters_.size(); ++k)
    file.tensors.push_back({concat("convolution.", k % 2 == 0 ? 'W' : 'b', k / 2 + 1),
                            parameters_[k].sizes().vec(), floats_of(parameters_[k])});
}

std::vector<double> ConvDenoiser::sample(const double* features, uint64_t seed) const {
  const at::NoGradGuard no_gradients;
  const at::Tensor f = standardised({features, 1, int(scale_.mean.size())}, scale_, device_);
  const Denoise denoise = [&](std::span<const double> x, int t, std::span<double> to) {
    const at::Tensor now = tensor_of({x.data(), 1, int(x.size())}, device_);
    const at::Tensor time = at::full({1}, t, at::TensorOptions().dtype(at::kLong).device(device_));
    const std::vector<float> result = floats_of(x0(parameters_, now, time, f));
    std::copy(result.begin(), result.end(), to.begin());
  };
  return sample_ddim(denoise, int64_t(side_) * side_, seed, kDdimSteps, noise_schedule());
}

}  // namespace elastogen
