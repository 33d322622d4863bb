// SPDX-License-Identifier: Apache-2.0
#include "diffusion/autoencoder_torch.hpp"

#include "core/error.hpp"
#include "core/hash.hpp"
#include "diffusion/double_tensors.hpp"

#include <ATen/ATen.h>
#include <ATen/core/grad_mode.h>

#include <algorithm>

namespace elastogen {
namespace {

constexpr int64_t kMostLayers = 16, kWidest = 1 << 17;
constexpr int64_t kBlock = 256;  // nets encoded at once

std::string layer_name(size_t k) {
  return concat("autoencoder.", k % 2 == 0 ? 'W' : 'b', k / 2 + 1);
}

at::Tensor floats(In<float> values) {
  return at::from_blob(const_cast<float*>(values.data), {values.rows, values.cols}, at::kFloat);
}

/// Sizes of the layers of encoder and decoder in sequence.
std::vector<std::pair<int64_t, int64_t>> shapes_of(const std::vector<int64_t>& layers) {
  std::vector<std::pair<int64_t, int64_t>> shapes;
  for (size_t k = 1; k < layers.size(); ++k) shapes.emplace_back(layers[k], layers[k - 1]);
  for (size_t k = layers.size() - 1; k > 0; --k) shapes.emplace_back(layers[k - 1], layers[k]);
  return shapes;
}

/// Applies layers with SiLU between them; `first` is the index of the first parameter.
at::Tensor through(const Parameters& parameters, size_t first, size_t layers, at::Tensor a) {
  for (size_t k = 0; k < layers; ++k) {
    const size_t at = first + 2 * k;
    a = at::addmm(parameters[at + 1], a, parameters[at].t());
    if (k + 1 < layers) a = at::silu(a);
  }
  return a;
}

}  // namespace

Autoencoder::Autoencoder(In<float> nets, const std::vector<int64_t>& layers, uint64_t seed,
                         at::Device device)
    : layers_{nets.cols}, device_(device) {
  ELASTOGEN_CHECK(nets.rows > 0 && !layers.empty() && int64_t(layers.size()) < kMostLayers &&
                      std::all_of(layers.begin(), layers.end(),
                                  [](int64_t size) { return size > 0 && size <= kWidest; }),
                  "an autoencoder needs nets and 1 to ", kMostLayers - 1, " layers of 1 to ",
                  kWidest);
  layers_.insert(layers_.end(), layers.begin(), layers.end());
  const at::Tensor all = floats(nets).to(at::kDouble);
  const at::Tensor mean = all.mean(0), spread = (all - mean).square().mean(0).sqrt();
  // a weight that is equal in all nets has a spread of the rounding of its mean
  const at::Tensor varies = spread > 1e-6 * mean.abs();
  mean_ = mean.to(at::kFloat).to(device);
  varies_ = varies.to(at::kFloat).to(device);
  scale_ = (spread * varies).to(at::kFloat).to(device);
  at::Generator random = step_generator(seed, -1);
  for (const auto& [rows, columns] : shapes_of(layers_))
    add_linear(parameters_, rows, columns, random, device);
}

Autoencoder::Autoencoder(const TensorFile& file, at::Device device) : device_(device) {
  const int64_t count = get_count(file, "autoencoder.layers", 1, kMostLayers - 1);
  for (int64_t k = 0; k <= count; ++k)
    layers_.push_back(get_count(file, concat("autoencoder.size", k), 1, kWidest));
  const auto take = [&](const std::string& name, const std::vector<int64_t>& shape) {
    const std::vector<float>& values = file.get(name, shape).values;
    return at::from_blob(const_cast<float*>(values.data()), shape, at::kFloat).clone().to(device);
  };
  mean_ = take("autoencoder.mean", {net_size()});
  scale_ = take("autoencoder.scale", {net_size()});
  varies_ = (scale_ > 0).to(at::kFloat);
  for (const auto& [rows, columns] : shapes_of(layers_)) {
    parameters_.push_back(take(layer_name(parameters_.size()), {rows, columns}));
    parameters_.push_back(take(layer_name(parameters_.size()), {rows}));
  }
}

void Autoencoder::write(TensorFile& file) const {
  file.text["autoencoder.layers"] = std::to_string(layers_.size() - 1);
  for (size_t k = 0; k < layers_.size(); ++k)
    file.text[concat("autoencoder.size", k)] = std::to_string(layers_[k]);
  file.tensors.push_back({"autoencoder.mean", {net_size()}, floats_of(mean_)});
  file.tensors.push_back({"autoencoder.scale", {net_size()}, floats_of(scale_)});
  for (size_t k = 0; k < parameters_.size(); ++k)
    file.tensors.push_back(
        {layer_name(k), parameters_[k].sizes().vec(), floats_of(parameters_[k])});
}

at::Tensor Autoencoder::standardised(In<float> nets) const {
  const at::Tensor size = at::where(varies_ > 0, scale_, at::ones_like(scale_));
  return (floats(nets).to(device_) - mean_) / size * varies_;
}

at::Tensor Autoencoder::encoded(const Parameters& parameters, const at::Tensor& nets) const {
  return through(parameters, 0, layers_.size() - 1, nets);
}

at::Tensor Autoencoder::decoded(const Parameters& parameters, const at::Tensor& codes) const {
  return through(parameters, 2 * (layers_.size() - 1), layers_.size() - 1, codes);
}

at::Tensor Autoencoder::loss(const Parameters& parameters, const at::Tensor& nets) const {
  const at::Tensor miss = (decoded(parameters, encoded(parameters, nets)) - nets) * varies_;
  return (miss * miss).sum() / (varies_.sum().clamp_min(1) * nets.size(0));
}

bool Autoencoder::train(In<float> nets, const AutoencoderOptions& options, const FitHooks& hooks) {
  ELASTOGEN_CHECK(nets.cols == net_size() && options.batch > 0, "nets must have ", net_size(),
                  " weights and the batch must be positive, got ", nets, " and ", options.batch);
  LoopOptions loop = options.loop;
  loop.identity = concat("autoencoder steps ", loop.steps, " batch ", options.batch, " rate ",
                         loop.rate, " seed ", options.seed, " layers");
  for (const int64_t size : layers_) loop.identity += concat(' ', size);
  loop.identity +=
      " nets " +
      hex(sha256({reinterpret_cast<const char*>(nets.data), size_t(nets.size()) * sizeof(float)}));
  const at::Tensor all = standardised(nets);
  const StepLoss step_loss = [&](const Parameters& parameters, int64_t step) {
    at::Generator random = step_generator(options.seed, step);
    const at::Tensor rows = at::randint(0, all.size(0), {options.batch}, random, at::kLong);
    return loss(parameters, all.index_select(0, rows.to(device_)));
  };
  LoopOutcome outcome = train_loop(parameters_, step_loss, loop, hooks);
  if (outcome.steps < loop.steps) return false;
  parameters_ = std::move(outcome.parameters);
  return true;
}

Array<double> Autoencoder::encode(In<float> nets) const {
  const at::NoGradGuard no_gradients;
  Array<double> codes(nets.rows, int(code_size()));
  for (int64_t n = 0; n < nets.rows; n += kBlock) {
    const Span<const float> block{nets.row(n), std::min(kBlock, nets.rows - n), nets.cols};
    const std::vector<float> part = floats_of(encoded(parameters_, standardised(block)));
    std::copy(part.begin(), part.end(), codes.row(n));
  }
  return codes;
}

Array<float> Autoencoder::decode(In<double> codes) const {
  const at::NoGradGuard no_gradients;
  Array<float> nets(codes.rows, int(net_size()));
  for (int64_t n = 0; n < codes.rows; n += kBlock) {
    const Span<const double> block{codes.row(n), std::min(kBlock, codes.rows - n), codes.cols};
    const at::Tensor out = decoded(parameters_, tensor_of(block, device_));
    const std::vector<float> part = floats_of(mean_ + scale_ * out);
    std::copy(part.begin(), part.end(), nets.row(n));
  }
  return nets;
}

double Autoencoder::error(In<float> nets) const {
  const at::NoGradGuard no_gradients;
  double sum = 0;
  for (int64_t n = 0; n < nets.rows; n += kBlock) {
    const Span<const float> block{nets.row(n), std::min(kBlock, nets.rows - n), nets.cols};
    sum += loss(parameters_, standardised(block)).item<double>() * double(block.rows);
  }
  return std::sqrt(sum / double(nets.rows));
}

}  // namespace elastogen
