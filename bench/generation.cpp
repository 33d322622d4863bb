// SPDX-License-Identifier: Apache-2.0
// How soon a net for a material never seen is good enough, by where its last layer begins: random
// materials of diffusion/material_family.hpp, of another seed than a dataset's, fitted for some
// iterations each (training/last_layer_fit.hpp) and judged on strains that no fit has seen.
//
//   generation FOLDER [--count N] [--seed S] [--generator FILE] [--only START] [--json FILE]
//
// FOLDER has hidden.tensors, hidden-sums.tensors and, unless named, generator.tensors; without it
// there are only the starts at 0. Prints Markdown tables.

#include "bench/generation_arguments.hpp"
#include "bench/generation_tables.hpp"
#include "training/hidden_layers.hpp"
#include "training/strain_sampler.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <string_view>

namespace elastogen::bench {
namespace {

constexpr int64_t kStrains = 4000;  // of a report

constexpr const char* kUsage =
    "usage: generation FOLDER [--count N] [--seed S] [--generator FILE] [--only START] "
    "[--json FILE]";

/// The one that is named, or that of the folder, where it has one.
std::optional<WeightGenerator> find_generator(const Arguments& arguments,
                                              const std::vector<float>& hidden) {
  const bool named = !arguments.generator.empty();
  const std::string path = named ? arguments.generator : arguments.folder + "/generator.tensors";
  if (!named && !std::filesystem::exists(path)) return std::nullopt;
  return read_generator(path, hidden);
}

/// Hidden layers drawn as training/fit_neural_mtl.hpp begins.
std::vector<float> drawn_hidden(uint64_t seed) {
  std::vector<float> drawn;
  for (int64_t k = 0; k < kMtlParameters; ++k)
    drawn.push_back(
        float((2 * counted_uniform(seed, 1, uint64_t(k)) - 1) / std::sqrt(k < 512 ? 3.0 : 128.0)));
  return drawn;
}

ReportOptions judged() {
  ReportOptions options;
  options.strains = kStrains;
  return options;
}

using MakeStart = std::function<std::vector<float>(const FitMaterial&, uint64_t)>;

/// Hidden layers and the fits on them.
struct Layers {
  explicit Layers(std::vector<float> hidden) : weights(std::move(hidden)), fits(weights) {}

  std::vector<float> weights;
  LastLayer fits;
};

/// A way to begin, and the hidden layers for it.
struct Way {
  std::string name;
  std::function<const Layers&(const FitMaterial&)> layers_of;
  MakeStart make_start;
};

std::vector<float> zero(const FitMaterial&, uint64_t) {
  return std::vector<float>(kMtlWidthOfLast);
}

/// Fits each material in all ways, one after another, so that whatever else the machine does slows
/// all of them.
void run_ways(const std::vector<Way>& ways, Results& results) {
  for (const Way& way : ways) results.methods.push_back({way.name, {}});
  for (size_t n = 0; n < results.materials.size(); ++n) {
    const FitMaterial& material = results.materials[n];
    for (size_t w = 0; w < ways.size(); ++w) {
      const Way& way = ways[w];
      const auto begin = std::chrono::steady_clock::now();
      const std::vector<float> start = way.make_start(material, n);
      const std::chrono::duration<double> passed = std::chrono::steady_clock::now() - begin;
      const Layers& layers = way.layers_of(material);
      results.methods[w].courses.push_back(
          {passed.count(),
           fit_from(layers.fits, layers.weights, material, start, kIterations, judged())});
    }
    if ((n + 1) % 20 == 0) fmt::print(stderr, "{} materials\n", n + 1);
  }
}

/// The codec alone: the best net of each material that a fit has ended in, there and back.
void judge_codec(const WeightGenerator& generator, const std::vector<float>& hidden,
                 Results& results) {
  for (size_t n = 0; n < results.materials.size(); ++n) {
    const StartFit* best = nullptr;
    for (size_t m = 1; m < results.methods.size(); ++m) {  // not on random hidden layers
      const StartFit& fit = results.methods[m].courses[n].fits.back();
      if (!best || fit.report.stress_p99 < best->report.stress_p99) best = &fit;
    }
    Array<float> layer(1, kMtlWidthOfLast);
    std::copy(best->layer.begin(), best->layer.end(), layer.data());
    const Array<double> code = generator.codec().encode(layer);
    const std::vector<float> decoded = generator.codec().decode({code.data(), size_t(code.cols())});
    std::vector<float> weights = hidden;
    std::copy(decoded.begin(), decoded.end(), weights.end() - kMtlLast);
    results.decoded.push_back(fit_report(results.materials[n], weights, judged()));
  }
  results.components = generator.codec().components();
}

/// All starts on the layers of most materials, and what the command does: sums that have layers of
/// their own (training/hidden_layers.hpp) begin there, at 0, all others at the regression. No
/// member of the family has the limits of Gent's law that have layers of their own.
std::vector<Way> all_ways(const Layers& drawn, const Layers& shipped, const Layers& sums,
                          const WeightGenerator* generator) {
  const auto on_shipped = [&shipped](const FitMaterial&) -> const Layers& { return shipped; };
  std::vector<Way> ways = {{"random hidden layers, zero",
                            [&drawn](const FitMaterial&) -> const Layers& { return drawn; }, zero}};
  if (!generator) ways.push_back({name_of(Start::kZero), on_shipped, zero});
  for (const Start start : kStarts) {
    if (!generator || (start == Start::kDiffusion && !generator->has_denoiser())) continue;
    ways.push_back(
        {name_of(start), on_shipped, [generator, start](const FitMaterial& m, uint64_t n) {
           return generator->last_layer(m, start, n);
         }});
  }
  const auto sum = [](const FitMaterial& m) {
    return std::string_view(hidden_layers_of(m)) == kSumHiddenLayers;
  };
  ways.push_back({"command",
                  [sum, &shipped, &sums](const FitMaterial& m) -> const Layers& {
                    return sum(m) ? sums : shipped;
                  },
                  [sum, generator](const FitMaterial& m, uint64_t n) {
                    return sum(m) || !generator ? zero(m, n)
                                                : generator->last_layer(m, Start::kRegression, n);
                  }});
  return ways;
}

void run(const Arguments& arguments) {
  const std::vector<float> hidden = read_hidden(arguments.folder);
  const std::optional<WeightGenerator> generator = find_generator(arguments, hidden);
  Results results;
  results.seed = arguments.seed, results.strains = kStrains;
  for (int64_t n = 0; n < arguments.count; ++n)
    results.materials.push_back(family_material(arguments.seed, uint64_t(n)));
  const Layers drawn(drawn_hidden(arguments.seed)), shipped(hidden),
      sums(read_hidden(arguments.folder, kSumHiddenLayers));
  std::vector<Way> ways = all_ways(drawn, shipped, sums, generator ? &*generator : nullptr);
  if (!arguments.only.empty())
    std::erase_if(ways, [&](const Way& way) { return way.name != arguments.only; });
  ELASTOGEN_CHECK(!ways.empty(), "--only '", arguments.only, "': there is no such start");
  run_ways(ways, results);
  if (generator && ways.size() > 1) judge_codec(*generator, hidden, results);
  print_tables(results);
  if (!arguments.json.empty()) write_file(arguments.json, json_of(results));
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  try {
    elastogen::bench::run(elastogen::bench::arguments_of(argc, argv, elastogen::bench::kUsage));
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "generation: {}\n", error.what());
    return 1;
  }
}
