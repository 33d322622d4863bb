// SPDX-License-Identifier: Apache-2.0
#include "cli/weight_start.hpp"

#include "diffusion/generate_weights.hpp"
#include "diffusion/hidden_hash.hpp"
#include "io/safe_file.hpp"
#include "scene/nets.hpp"

namespace elastogen {
namespace {

constexpr int64_t kMostGenerator = 1 << 28;

/// Where a fit starts; empty for zero weights.
std::vector<float> start_of(const FitMaterial& material, std::span<const float> hidden) {
  const std::string path = find_weight_file(kGenerator);
  if (path.empty()) return {};
  const WeightGenerator generator(decode_tensors(read_file(path, kMostGenerator), path), path);
  if (generator.hidden() != hidden_hash(hidden)) return {};
  return generator.last_layer(material, Start::kRegression);
}

JudgedFit judged_fit(const LastLayer& layer, const FitMaterial& material,
                     std::span<const float> start) {
  LastLayerFit fit = layer.fit(material, start);
  const FitReport report = fit_report(material, fit.weights);
  return {std::move(fit), report};
}

}  // namespace

JudgedFit fit_with_start(const LastLayer& layer, std::span<const float> hidden,
                         const FitMaterial& material) {
  const std::vector<float> start = start_of(material, hidden);
  JudgedFit judged = judged_fit(layer, material, start);
  if (start.empty() || judged.report.passes()) return judged;
  return judged_fit(layer, material, {});
}

}  // namespace elastogen
