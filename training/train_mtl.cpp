// SPDX-License-Identifier: Apache-2.0
#include "training/train_mtl.hpp"

#include "core/error.hpp"
#include "io/safe_file.hpp"
#include "training/last_layer_fit.hpp"
#include "training/mtl_files.hpp"

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <optional>
#include <ranges>
#include <span>

namespace elastogen {
namespace {

namespace fs = std::filesystem;

std::vector<FitMaterial> materials_of(const TrainMtl& task) {
  if (task.list.empty()) return {fit_material(task.law, task.poisson)};
  return read_fit_materials(read_file(task.list, 1 << 20), task.list);
}

void make_folder(const std::string& path) {
  std::error_code error;
  fs::create_directories(path, error);
  if (error)
    throw Error(concat("cannot make the folder ", path, ": ", error.message()),
                ErrorKind::kResources);
}

/// Reports the errors. @return how many nets pass.
int64_t say_reports(const std::vector<FitMaterial>& materials,
                    const std::vector<FitReport>& reports, const FitHooks& hooks) {
  for (size_t n = 0; n < reports.size(); ++n) {
    const FitReport& r = reports[n];
    char line[256];
    std::snprintf(line, sizeof line,
                  "%s: stress median %.3f %%, p99 %.3f %%, max %.2f %%; tangent p99 %.2f %%: %s",
                  materials[n].name.c_str(), 100 * r.stress_median, 100 * r.stress_p99,
                  100 * r.stress_max, 100 * r.tangent_p99, r.passes() ? "passes" : "FAILS");
    hooks.say(line);
  }
  const auto passing =
      std::count_if(reports.begin(), reports.end(), [](const FitReport& r) { return r.passes(); });
  hooks.say(concat(passing, " of ", reports.size(), " inside all limits"));
  return passing;
}

/// The model card's texts on how the weights of a task were made.
TrainerCard trainer_card(const TrainMtl& task, const FitOptions& options) {
  return {{"trainer.steps", std::to_string(options.steps)},
          {"trainer.samples", std::to_string(options.samples)},
          {"trainer.rate", shortest_text(options.rate)},
          {"trainer.seed", std::to_string(options.seed)},
          {"trainer.start", start_name(options)},
          {"trainer.hidden", options.shared || options.steps == 0 ? "shared" : "own"},
          {"trainer.last_layer", std::to_string(task.last_layer)}};
}

std::span<const float> row(const Array<float>& weights, size_t n) {
  return {weights.row(int64_t(n)), size_t(kMtlParameters)};
}

/// A copy of the start for each material.
Array<float> copies(const std::vector<float>& start, size_t count) {
  Array<float> weights(int64_t(count), kMtlParameters);
  for (size_t n = 0; n < count; ++n) std::copy(start.begin(), start.end(), weights.row(int64_t(n)));
  return weights;
}

/// Fits the last layers. Features are reused for equal hidden layers and boxes.
void fit_last_layers(const std::vector<FitMaterial>& materials, int iterations,
                     Array<float>& weights) {
  LastLayerOptions options;
  options.iterations = iterations;
  std::optional<LastLayer> layer;
  for (size_t n = 0; n < materials.size(); ++n) {
    const auto now = row(weights, n);
    const StrainBox box = fit_box({&materials[n], 1});
    const auto hidden = [](std::span<const float> w) { return w.first(w.size() - kMtlLast); };
    if (n == 0 || box.invariant != options.box.invariant ||
        !std::ranges::equal(hidden(now), hidden(row(weights, n - 1)))) {
      options.box = box;
      layer.emplace(now, options);
    }
    const LastLayerFit fit = layer->fit(materials[n], now.last(kMtlLast).first(kMtlLast - 1));
    std::copy(fit.weights.begin(), fit.weights.end(), weights.row(int64_t(n)));
  }
}

/// Weights of all layers; without steps those of the start; empty if stopped before the last step.
Array<float> all_layers(const std::vector<FitMaterial>& materials, const FitOptions& options,
                        const FitHooks& hooks) {
  if (options.steps == 0) return copies(options.start, materials.size());
  FitOutcome outcome = fit_neural_mtl(materials, options, hooks);
  if (outcome.steps == options.steps) return std::move(outcome.weights);
  hooks.say(concat("stopped at step ", outcome.steps, "; --resume goes on"));
  return {};
}

/// Writes the weights of each material, and for a list its table and shared hidden layers.
void write_all(const TrainMtl& task, const std::vector<FitMaterial>& materials,
               const Array<float>& weights, const std::vector<FitReport>& reports,
               const TrainerCard& trainer) {
  const bool many = !task.list.empty();
  for (size_t n = 0; n < materials.size(); ++n) {
    const TensorFile file = mtl_file(materials[n], row(weights, n), reports[n], trainer);
    const std::string path = many ? task.out + '/' + materials[n].name + ".weights" : task.out;
    write_file(path, encode_tensors(file));
  }
  if (!many) return;
  write_file(task.out + "/report.csv", report_table(materials, reports));
  if (task.fit.shared)
    write_file(task.out + "/hidden.tensors", encode_tensors(hidden_file(row(weights, 0), trainer)));
}

}  // namespace

TrainEnd train_mtl(const TrainMtl& task, const FitHooks& hooks) {
  // check the task
  const std::vector<FitMaterial> materials = materials_of(task);
  ELASTOGEN_CHECK(!task.out.empty(), "name an output");
  ELASTOGEN_CHECK(task.fit.steps >= 0 && task.last_layer >= 0, "steps must not be negative, got ",
                  task.fit.steps, " and ", task.last_layer);
  ELASTOGEN_CHECK(task.fit.steps > 0 || !task.start.empty(),
                  "without steps the hidden layers need a start (--start)");
  const bool many = !task.list.empty();
  if (many) make_folder(task.out);
  // the start, and a checkpoint for interruptions
  FitOptions options = task.fit;
  if (!task.start.empty()) {
    const TensorFile file = decode_tensors(read_file(task.start, 1 << 24), task.start);
    options.start = file.get("neural_mtl", {kMtlParameters}).values;
  }
  options.checkpoint = many ? task.out + "/checkpoint.part" : task.out + ".part";

  // all layers by gradient steps, then the last layers by least squares
  Array<float> weights = all_layers(materials, options, hooks);
  if (weights.empty()) return TrainEnd::kStopped;
  if (task.last_layer > 0) fit_last_layers(materials, task.last_layer, weights);
  // judge the nets
  std::vector<FitReport> reports;
  for (size_t n = 0; n < materials.size(); ++n)
    reports.push_back(fit_report(materials[n], row(weights, n)));
  const int64_t passing = say_reports(materials, reports, hooks);

  // write, even if some nets miss their limits
  write_all(task, materials, weights, reports, trainer_card(task, options));
  std::error_code ignored;
  fs::remove(options.checkpoint, ignored);
  return passing == int64_t(reports.size()) ? TrainEnd::kPassing : TrainEnd::kFailing;
}

}  // namespace elastogen
