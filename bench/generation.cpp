// SPDX-License-Identifier: Apache-2.0
// How soon a net for an unseen material is good enough, by where its last layer starts: random
// materials of diffusion/material_family.hpp, with another seed than a dataset's, fitted for some
// iterations each (training/last_layer_fit.hpp) and judged on strains that no fit has used.
//
//   generation FOLDER [--count N] [--seed S] [--generator FILE] [--only START] [--json FILE]
//
// FOLDER has hidden.tensors, hidden-sums.tensors and, unless it is named, generator.tensors.
// Without a generator there are only the starts at 0. Prints Markdown tables.

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

constexpr int64_t kStrains = 4000;  // strains of a report

constexpr const char* kUsage =
    "usage: generation FOLDER [--count N] [--seed S] [--generator FILE] [--only START] "
    "[--json FILE]";

/// The named generator, else that of the folder, if it has one.
std::optional<WeightGenerator> find_generator(const Arguments& arguments,
                                              const std::vector<float>& hidden) {
  const bool named = !arguments.generator.empty();
  const std::string path = named ? arguments.generator : arguments.folder + "/generator.tensors";
  if (!named && !std::filesystem::exists(path)) return std::nullopt;
  return read_generator(path, hidden);
}

/// Random hidden layers, drawn as at the start of training/fit_neural_mtl.hpp.
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

/// A method to start a fit, and the hidden layers for it.
struct Way {
  std::string name;
  std::function<const Layers&(const FitMaterial&)> layers_of;
  MakeStart make_start;
};

std::vector<float> zero(const FitMaterial&, uint64_t) {
  return std::vector<float>(kMtlWidthOfLast);
}

/// Fits each material with all starts, one after another, so that other load on the machine slows
/// all of them alike.
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

/// Judges the codec alone: the best fitted net of each material, encoded and decoded.
void judge_codec(const WeightGenerator& generator, const std::vector<float>& hidden,
                 Results& results) {
  for (size_t n = 0; n < results.materials.size(); ++n) {
    const StartFit* best = nullptr;
    for (size_t m = 1; m < results.methods.size(); ++m) {  // leaves out random hidden layers
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

/// All starts on the hidden layers of most materials, and the choice of the command. That starts
/// sums with hidden layers of their own (training/hidden_layers.hpp) at 0 on these, all others at
/// the regression. No material of the family has the hidden layers for near limits of Gent's law.
std::vector<Way> all_ways(const Layers& drawn, const Layers& shipped, const Layers& sums,
                          const WeightGenerator* generator) {
  // zeros, on random and on shipped hidden layers
  const auto on_shipped = [&shipped](const FitMaterial&) -> const Layers& { return shipped; };
  std::vector<Way> ways = {{"random hidden layers, zero",
                            [&drawn](const FitMaterial&) -> const Layers& { return drawn; }, zero}};
  if (!generator) ways.push_back({name_of(Start::kZero), on_shipped, zero});
  // what the generator gives
  for (const Start start : kStarts) {
    if (!generator || (start == Start::kDiffusion && !generator->has_denoiser())) continue;
    ways.push_back(
        {name_of(start), on_shipped, [generator, start](const FitMaterial& m, uint64_t n) {
           return generator->last_layer(m, start, n);
         }});
  }
  // the choice of the command
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
