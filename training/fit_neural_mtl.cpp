// SPDX-License-Identifier: Apache-2.0
#include "training/fit_neural_mtl.hpp"

#include "core/error.hpp"
#include "core/hash.hpp"
#include "core/stopwatch.hpp"
#include "training/fit_checkpoint.hpp"
#include "training/fit_problem_torch.hpp"
#include "training/soap_torch.hpp"
#include "training/strain_sampler.hpp"

#include <ATen/ATen.h>
#include <torch/csrc/autograd/autograd.h>

#include <cmath>
#include <cstdio>
#include <numbers>

namespace elastogen {
namespace {

constexpr double kTangentWeight = 0.1, kEnergyWeight = 0.1, kEnergyClip = 3;
constexpr double kLossFloor = 1e-8;            // least loss in a logarithm
constexpr int64_t kStepsBetweenReports = 200;  // between two lines of progress

/// The weights at the start: one start for all nets, or one for each.
at::Tensor initial_block(int64_t nets, const std::vector<float>& start, at::Device device) {
  Array<float> weights(nets, kMtlParameters);
  const bool one = int64_t(start.size()) == kMtlParameters;
  for (int64_t n = 0; n < nets; ++n)
    std::copy_n(start.begin() + (one ? 0 : n * kMtlParameters), kMtlParameters, weights.row(n));
  return block_of_weights(weights, device);
}

/// Weights of all nets, and SOAP on [W1 b1], [W2 b2], w3. If hidden layers are shared, each net has
/// a copy of them.
struct Optimiser {
  Optimiser(int64_t nets, bool shared_layers, const std::vector<float>& start, at::Device device)
      : shared(shared_layers),
        block(initial_block(nets, start, device)),
        parts{Soap(shared ? 1 : nets, kMtlWidth, 4, device),
              Soap(shared ? 1 : nets, kMtlWidth, kMtlWidth + 1, device),
              Soap(nets, 1, kMtlWidth, device)} {}

  /// @param gradient  with respect to the weights, in their shapes
  void descend(const MtlNets& gradient, double rate) {
    ++step;
    const MtlNets w = nets_of_block(block);
    const auto layer = [&](Soap& soap, const at::Tensor& W, const at::Tensor& b,
                           const at::Tensor& dW, const at::Tensor& db) {
      const int64_t inputs = W.size(2);
      at::Tensor g = at::cat({dW, db.unsqueeze(2)}, 2);
      if (shared) g = g.sum(0, true);
      const at::Tensor d = soap.update(g, rate, step);
      W.sub_(d.narrow(2, 0, inputs));
      b.sub_(d.select(2, inputs));
    };
    layer(parts[0], w.W1, w.b1, gradient.W1, gradient.b1);
    layer(parts[1], w.W2, w.b2, gradient.W2, gradient.b2);
    w.w3.sub_(parts[2].update(gradient.w3.unsqueeze(1), rate, step).squeeze(1));
  }

  /// All numbers that decide the next steps, except `step`.
  std::vector<at::Tensor*> state() {
    std::vector<at::Tensor*> all = {&block};
    for (Soap& part : parts)
      for (at::Tensor* tensor : part.state()) all.push_back(tensor);
    return all;
  }

  bool shared;
  at::Tensor block;  ///< in the form of nets_of_block
  std::array<Soap, 3> parts;
  int64_t step = 0;
};

double rate_at(const FitOptions& options, int64_t step) {
  const double rise = std::min(1.0, double(step + 1) / double(options.warm_up));
  const double fall = (1 + std::cos(std::numbers::pi * double(step) / double(options.steps))) / 2;
  return options.rate * rise * fall;
}

/// Loss of each net.
at::Tensor losses(const BatchErrors& errors) {
  const at::Tensor energy = errors.energy.clamp(-kEnergyClip, kEnergyClip);
  return errors.stress.mean(1) + kTangentWeight * errors.tangent.mean(1) +
         kEnergyWeight * (energy * energy).mean(1);
}

/// Gradient of the sum of losses, or of their logarithms, with respect to the weights; `loss` gets
/// the loss of each net.
MtlNets loss_gradient(const FitProblem& problem, const at::Tensor& block, const Array<double>& e,
                      int64_t second, bool logarithms, at::Tensor& loss) {
  MtlNets nets = nets_of_block(block);
  std::vector<at::Tensor> leaves;
  for (at::Tensor* part : {&nets.W1, &nets.b1, &nets.W2, &nets.b2, &nets.w3}) {
    *part = part->detach().requires_grad_();
    leaves.push_back(*part);
  }
  const at::Tensor all = losses(problem.errors(nets, e, second));
  const at::Tensor sum = logarithms ? (all + kLossFloor).log().sum() : all.sum();
  const std::vector<at::Tensor> g = torch::autograd::grad({sum}, leaves);
  loss = all.detach();
  return {g[0], g[1], g[2], g[3], g[4]};
}

class Run {
 public:
  Run(const std::vector<FitMaterial>& materials, const FitOptions& options, const FitHooks& hooks)
      : materials_(materials),
        options_(options),
        hooks_(hooks),
        device_(fit_device(options.device)),
        problem_(materials, device_),
        optimiser_(int64_t(materials.size()), options.shared,
                   options.start.empty() ? initial_weights(options.seed) : options.start, device_) {
    if (options.resume) load();
  }

  FitOutcome run() {
    begin_ = optimiser_.step;
    while (optimiser_.step < options_.steps && !hooks_.stopped()) {
      step();
      const bool last = optimiser_.step == options_.steps;
      if (last || optimiser_.step % kStepsBetweenReports == 0) say_progress();
      if (last || optimiser_.step % options_.checkpoint_steps == 0) save();
    }
    if (optimiser_.step < options_.steps) save();
    return {weights_of_block(optimiser_.block), optimiser_.step, watch_.seconds()};
  }

 private:
  void step() {
    const auto first = uint64_t(optimiser_.step) * uint64_t(options_.samples);
    const Array<double> e = sample_strains(box_, options_.seed, first, options_.samples);
    const int64_t second = (options_.samples + 2) / 3;
    const double rate = rate_at(options_, optimiser_.step);
    optimiser_.descend(loss_gradient(problem_, optimiser_.block, e, second, options_.shared, loss_),
                       rate);
  }

  void say_progress() const {
    const at::Tensor root = loss_.sqrt();
    char line[128];
    std::snprintf(line, sizeof line,
                  "step %6lld of %lld: root of the loss median %.3e worst %.3e, %.1f ms a step",
                  static_cast<long long>(optimiser_.step), static_cast<long long>(options_.steps),
                  root.median().item<double>(), root.max().item<double>(),
                  1e3 * watch_.seconds() / double(optimiser_.step - begin_));
    hooks_.say(line);
  }

  void save() {
    if (options_.checkpoint.empty()) return;
    FitCheckpoint checkpoint{optimiser_.step, {}};
    for (const at::Tensor* tensor : optimiser_.state()) {
      const at::Tensor host = tensor->cpu().contiguous();
      const float* data = host.data_ptr<float>();
      checkpoint.numbers.emplace_back(data, data + host.numel());
    }
    write_checkpoint(options_.checkpoint, materials_, options_, checkpoint);
  }

  void load() {
    const auto checkpoint =
        read_checkpoint(options_.checkpoint, materials_, options_, optimiser_.state().size());
    if (!checkpoint) return;
    optimiser_.step = checkpoint->step;
    size_t k = 0;
    for (at::Tensor* tensor : optimiser_.state()) {
      const std::vector<float>& numbers = checkpoint->numbers[k++];
      ELASTOGEN_CHECK_ASSET(int64_t(numbers.size()) == tensor->numel(), options_.checkpoint,
                            ": of other sizes");
      tensor->copy_(at::from_blob(const_cast<float*>(numbers.data()), tensor->sizes()));
    }
    hooks_.say(concat("resumed at step ", checkpoint->step));
  }

  const std::vector<FitMaterial>& materials_;
  StrainBox box_ = fit_box(materials_);
  const FitOptions& options_;
  const FitHooks& hooks_;
  at::Device device_;
  FitProblem problem_;
  Optimiser optimiser_;
  at::Tensor loss_;
  int64_t begin_ = 0;
  Stopwatch watch_;
};

}  // namespace

std::string start_name(const FitOptions& options) {
  if (options.start.empty()) return "random";
  const auto* bytes = reinterpret_cast<const char*>(options.start.data());
  return hex(sha256({bytes, options.start.size() * sizeof(float)}));
}

std::vector<float> initial_weights(uint64_t seed) {
  constexpr uint64_t kStream = 0x5eed;  // keeps these numbers apart from those of strains
  std::vector<float> weights;
  const auto add = [&](int count, int inputs) {
    const double bound = 1 / std::sqrt(double(inputs));
    for (int k = 0; k < count; ++k)
      weights.push_back(float(bound * (2 * counted_uniform(~seed, kStream, weights.size()) - 1)));
  };
  for (const int inputs : {3, kMtlWidth}) {
    add(kMtlWidth * inputs, inputs);
    add(kMtlWidth, inputs);
  }
  add(kMtlWidth, kMtlWidth);
  weights.push_back(0);
  return weights;
}

FitOutcome fit_neural_mtl(const std::vector<FitMaterial>& materials, const FitOptions& options,
                          const FitHooks& hooks) {
  ELASTOGEN_CHECK(!materials.empty(), "there is no material to fit");
  ELASTOGEN_CHECK(options.steps > 0 && options.samples >= 3 && options.warm_up > 0 &&
                      options.checkpoint_steps > 0,
                  "steps and samples must be positive, got ", options.steps, " and ",
                  options.samples);
  const auto weights = int64_t(options.start.size());
  const bool of_each = !options.shared && weights == int64_t(materials.size()) * kMtlParameters;
  ELASTOGEN_CHECK(weights == 0 || weights == kMtlParameters || of_each, "a start has ",
                  kMtlParameters, " weights, or as many for each net, got ", weights);
  at::globalContext().setFloat32MatmulPrecision("highest");  // no TF32, which has 11 bits
  return Run(materials, options, hooks).run();
}

}  // namespace elastogen
