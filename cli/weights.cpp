// SPDX-License-Identifier: Apache-2.0
#include "cli/weights.hpp"

#include "cli/weight_start.hpp"
#include "core/error.hpp"
#include "core/stopwatch.hpp"
#include "io/safe_file.hpp"
#include "network/law/mtl_weights.hpp"
#include "training/hidden_layers.hpp"
#include "training/last_layer_fit.hpp"
#include "training/mtl_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

namespace elastogen {
namespace {

namespace fs = std::filesystem;

constexpr int64_t kMostBytes = 1 << 24;

/// Hidden layers on which nets without a file are fitted.
struct HiddenLayers {
  TensorFile file;
  std::string hash;
};

HiddenLayers hidden_layers(const FitMaterial& material) {
  const char* const name = hidden_layers_of(material);
  const std::string path = find_weight_file(name);
  ELASTOGEN_CHECK(!path.empty(), "there are no weights of ", law_text(material.terms),
                  " with Poisson ratio ", material.poisson, ", and no ", name,
                  " to fit them on in ", fmt::format("{}", fmt::join(weight_folders(), ", ")));
  const std::string bytes = read_file(path, kMostBytes);
  return {decode_tensors(bytes, path), hex(sha256(bytes))};
}

MadeWeights made_on(const HiddenLayers& hidden, const FitMaterial& material) {
  const Stopwatch watch;
  LastLayerOptions options;
  options.enough = 1e-4;  // rms; the limits are on the median, p99 and largest error
  options.box = fit_box({&material, 1});
  if (near_limit(material)) options.iterations = 200;
  const std::vector<float>& layers = hidden.file.get("neural_mtl", {kMtlParameters}).values;
  const auto [fit, report] = fit_with_start(LastLayer(layers, options), layers, material);
  MadeWeights made;
  made.report = report;
  const TrainerCard trainer = {{"trainer.hidden", hidden.hash},
                               {"trainer.last_layer", std::to_string(fit.iterations)}};
  made.bytes = encode_tensors(mtl_file(material, fit.weights, made.report, trainer));
  made.iterations = fit.iterations;
  made.seconds = watch.seconds();
  return made;
}

std::string card_text(const TensorFile& weights, const std::string& key) {
  const auto found = weights.text.find(key);
  return found == weights.text.end() ? "" : found->second;
}

/// The bytes of a file of the cache, if it is undamaged and belongs to this material.
std::optional<std::string> kept_weights(const std::string& path, const FitMaterial& material) {
  std::error_code error;
  if (path.empty() || !fs::is_regular_file(path, error)) return std::nullopt;
  try {
    std::string bytes = read_file(path, kMostBytes);
    const TensorFile weights = decode_tensors(bytes, path);
    if (is_of(weights, material) && card_text(weights, "error.passes") == "yes") return bytes;
  } catch (const Error&) {  // damaged: it is made again
  }
  return std::nullopt;
}

void keep_weights(const std::string& path, const std::string& bytes) {
  if (path.empty()) return;
  std::error_code error;
  fs::create_directories(fs::path(path).parent_path(), error);
  try {
    write_file(path, bytes);
  } catch (const Error&) {  // the next run fits again
  }
}

}  // namespace

bool is_of(const TensorFile& weights, const FitMaterial& material) {
  return card_text(weights, "form") == kMtlForm &&
         card_text(weights, "law") == law_text(material.terms) &&
         card_text(weights, "poisson") == shortest_text(material.poisson);
}

MadeWeights made_weights(const FitMaterial& material) {
  return made_on(hidden_layers(material), material);
}

WeightFile weights_of(const FitMaterial& material) {
  const std::string name =
      concat(law_text(material.terms), '-', shortest_text(material.poisson), ".weights");
  if (const std::string path = find_weight_file(name); !path.empty())
    return {read_file(path, kMostBytes), path, {}};
  const HiddenLayers hidden = hidden_layers(material);
  std::string cached = weight_cache();
  if (!cached.empty()) cached += '/' + hidden.hash.substr(0, 16) + '-' + name;
  if (const auto bytes = kept_weights(cached, material)) return {*bytes, cached, {}};
  const MadeWeights made = made_on(hidden, material);
  if (made.report.passes()) keep_weights(cached, made.bytes);
  return {made.bytes, name, made.report};
}

std::shared_ptr<const LearnedLaw> make_net(const Material& m, Evaluation evaluation) {
  const WeightFile file = weights_of(fit_material(law_name(m.law), m.poisson));
  if (const std::optional<FitReport>& report = file.made)
    ELASTOGEN_CHECK(report->passes(), "no net: the fit to material '", m.name, "', ",
                    law_name(m.law), " with Poisson ratio ", m.poisson,
                    ", misses its limits: stress errors ", report->stress_median, " / ",
                    report->stress_p99, " / ", report->stress_max, ", tangent ",
                    report->tangent_p99);
  return read_weights(file.bytes, file.place, m.law, m.poisson, evaluation);
}

}  // namespace elastogen
