// SPDX-License-Identifier: Apache-2.0
#include "diffusion/train_loop_torch.hpp"

#include "core/error.hpp"
#include "core/stopwatch.hpp"
#include "core/tensor_file.hpp"
#include "io/safe_file.hpp"

#include <ATen/ATen.h>
#include <ATen/CPUGeneratorImpl.h>
#include <torch/csrc/autograd/autograd.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <numbers>

namespace elastogen {
namespace {

constexpr double kFirst = 0.9, kSecond = 0.999, kFloor = 1e-8;
constexpr int64_t kStepsBetweenLines = 500;       // between two lines of progress
constexpr int64_t kMostBytes = int64_t{1} << 34;  // largest checkpoint

class Loop {
 public:
  Loop(const Parameters& start, const StepLoss& loss, const LoopOptions& options,
       const FitHooks& hooks)
      : loss_(loss), options_(options), hooks_(hooks) {
    for (const at::Tensor& w : start) {
      w_.push_back(w.detach().clone());
      m_.push_back(at::zeros_like(w));
      v_.push_back(at::zeros_like(w));
      if (options.average > 0) a_.push_back(w_.back().clone());
    }
    if (options.resume) load();
  }

  LoopOutcome run() {
    const int64_t begin = step_;
    const Stopwatch watch;
    while (step_ < options_.steps && !hooks_.stopped()) {
      const double loss = descend();
      const bool last = step_ == options_.steps;
      if (last || step_ % kStepsBetweenLines == 0)
        say_progress(loss, watch.milliseconds() / double(step_ - begin));
      if (!last && step_ % options_.checkpoint_steps == 0) save();
    }
    if (step_ < options_.steps) save();
    return {options_.average > 0 ? a_ : w_, step_};
  }

 private:
  double rate() const {
    const double rise = std::min(1.0, double(step_ + 1) / double(options_.warm_up));
    const double share = double(step_) / double(options_.steps);
    return options_.rate * rise * (1 + std::cos(std::numbers::pi * share)) / 2;
  }

  /// @return the loss before the step, but only every few hundred steps, else 0: reading it waits.
  double descend() {
    Parameters leaves;
    for (const at::Tensor& w : w_) leaves.push_back(w.detach().requires_grad_());
    const at::Tensor loss = loss_(leaves, step_);
    const std::vector<at::Tensor> gradient = torch::autograd::grad({loss}, leaves);
    const double now = rate();
    ++step_;
    const double first = 1 - std::pow(kFirst, double(step_)),
                 second = 1 - std::pow(kSecond, double(step_));
    const double kept = std::min(options_.average, double(1 + step_) / double(10 + step_));
    for (size_t k = 0; k < w_.size(); ++k) {
      const at::Tensor& g = gradient[k];
      m_[k].mul_(kFirst).add_(g, 1 - kFirst);
      v_[k].mul_(kSecond).addcmul_(g, g, 1 - kSecond);
      w_[k].mul_(1 - now * options_.decay);
      w_[k].addcdiv_(m_[k], (v_[k] / second).sqrt_().add_(kFloor), -now / first);
      if (options_.average > 0) a_[k].mul_(kept).add_(w_[k], 1 - kept);
    }
    const bool asked = step_ == options_.steps || step_ % kStepsBetweenLines == 0;
    return asked ? loss.item<double>() : 0;
  }

  void say_progress(double loss, double ms) const {
    char line[128];
    std::snprintf(line, sizeof line, "step %6lld of %lld: loss %.3e, %.2f ms a step",
                  static_cast<long long>(step_), static_cast<long long>(options_.steps), loss, ms);
    hooks_.say(line);
  }

  /// All numbers that decide the next steps, beside the number of the step.
  std::vector<at::Tensor> state() const {
    std::vector<at::Tensor> all;
    for (const Parameters* part : {&w_, &m_, &v_, &a_})
      all.insert(all.end(), part->begin(), part->end());
    return all;
  }

  void save() const {
    if (options_.checkpoint.empty()) return;
    TensorFile file;
    file.text = {{"checkpoint.of", options_.identity}, {"checkpoint.step", std::to_string(step_)}};
    for (const at::Tensor& tensor : state())
      file.tensors.push_back(
          {std::to_string(file.tensors.size()), {tensor.numel()}, floats_of(tensor)});
    write_file(options_.checkpoint, encode_tensors(file));
  }

  void load() {
    const std::string& path = options_.checkpoint;
    if (!std::filesystem::exists(path)) return;
    TensorFile file = decode_tensors(read_file(path, kMostBytes), path);
    ELASTOGEN_CHECK_ASSET(file.text["checkpoint.of"] == options_.identity, path,
                          ": a checkpoint of other data or options");
    const std::string& text = file.text["checkpoint.step"];
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), step_);
    ELASTOGEN_CHECK_ASSET(error == std::errc() && end == text.data() + text.size() && step_ >= 0,
                          path, ": '", text, "' is no step");
    const std::vector<at::Tensor> all = state();
    ELASTOGEN_CHECK_ASSET(file.tensors.size() == all.size(), path, ": ", all.size(),
                          " tensors are needed, got ", file.tensors.size());
    for (size_t k = 0; k < all.size(); ++k) {
      std::vector<float>& values = file.tensors[k].values;
      ELASTOGEN_CHECK_ASSET(int64_t(values.size()) == all[k].numel(), path, ": of other sizes");
      all[k].copy_(at::from_blob(values.data(), all[k].sizes()));
    }
    hooks_.say(concat("resumed at step ", step_));
  }

  const StepLoss& loss_;
  const LoopOptions& options_;
  const FitHooks& hooks_;
  Parameters w_, m_, v_, a_;
  int64_t step_ = 0;
};

}  // namespace

LoopOutcome train_loop(const Parameters& start, const StepLoss& loss, const LoopOptions& options,
                       const FitHooks& hooks) {
  ELASTOGEN_CHECK(!start.empty() && options.steps > 0 && options.warm_up > 0 &&
                      options.checkpoint_steps > 0 && options.rate > 0,
                  "training needs parameters and positive steps and rate, got ", options.steps,
                  " and ", options.rate);
  at::globalContext().setFloat32MatmulPrecision("highest");  // no TF32, which has 11 bits
  return Loop(start, loss, options, hooks).run();
}

at::Generator step_generator(uint64_t seed, int64_t step) {
  // far apart, so that the random numbers of two seeds never overlap
  return at::make_generator<at::CPUGeneratorImpl>((seed + 1) * 0x9e3779b97f4a7c15 + uint64_t(step));
}

void add_linear(Parameters& parameters, int64_t rows, int64_t columns, at::Generator& generator,
                at::Device device) {
  const double bound = 1 / std::sqrt(double(columns));
  const at::Tensor W = at::empty({rows, columns}).uniform_(-bound, bound, generator);
  parameters.push_back(W.to(device));
  parameters.push_back(at::zeros({rows}, device));
}

std::vector<float> floats_of(const at::Tensor& tensor) {
  const at::Tensor host = tensor.detach().cpu().contiguous();
  const float* const data = host.data_ptr<float>();
  return {data, data + host.numel()};
}

at::Tensor tensor_of(In<double> values, at::Device device) {
  const at::Tensor host =
      at::from_blob(const_cast<double*>(values.data), {values.rows, values.cols}, at::kDouble);
  return host.to(at::kFloat).to(device);
}

}  // namespace elastogen
