// SPDX-License-Identifier: Apache-2.0
// How soon a net for a material never seen is good enough, by where its last layer begins: random
// materials of diffusion/material_family.hpp, of another seed than a dataset's, fitted for some
// iterations each (training/last_layer_fit.hpp) and judged on strains that no fit has seen.
//
//   generation FOLDER [--count N] [--seed S] [--generator FILE] [--only START] [--json FILE]
//
// FOLDER has hidden.tensors and, unless named, generator.tensors; without it there are only the
// starts at 0. Prints Markdown tables.

#include "bench/generation_tables.hpp"
#include "core/error.hpp"
#include "diffusion/generate_weights.hpp"
#include "diffusion/hidden_hash.hpp"
#include "io/safe_file.hpp"
#include "training/strain_sampler.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

namespace elastogen::bench {
namespace {

constexpr int64_t kStrains = 4000;  // of a report

struct Arguments {
  std::string folder, generator, only, json;
  int64_t count = 200;
  uint64_t seed = 1'000'003;
};

Arguments arguments_of(int argc, char** argv) {
  Arguments arguments;
  for (int k = 1; k < argc; ++k) {
    const std::string word = argv[k];
    if (word[0] != '-') {
      arguments.folder = word;
      continue;
    }
    ELASTOGEN_CHECK(k + 1 < argc, word, " needs a value");
    const char* const value = argv[++k];
    if (word == "--count")
      arguments.count = std::atoll(value);
    else if (word == "--seed")
      arguments.seed = std::strtoull(value, nullptr, 10);
    else if (word == "--generator")
      arguments.generator = value;
    else if (word == "--only")
      arguments.only = value;
    else if (word == "--json")
      arguments.json = value;
    else
      throw Error(concat("unknown option ", word));
  }
  ELASTOGEN_CHECK(!arguments.folder.empty() && arguments.count > 0,
                  "usage: generation FOLDER [--count N] [--seed S] [--generator FILE] "
                  "[--only START] [--json FILE]");
  return arguments;
}

std::vector<float> read_hidden(const std::string& folder) {
  const std::string path = folder + "/hidden.tensors";
  return decode_tensors(read_file(path, 1 << 24), path).get("neural_mtl", {kMtlParameters}).values;
}

std::optional<WeightGenerator> read_generator(const Arguments& arguments,
                                              const std::vector<float>& hidden) {
  const bool named = !arguments.generator.empty();
  const std::string path = named ? arguments.generator : arguments.folder + "/generator.tensors";
  if (!named && !std::filesystem::exists(path)) return std::nullopt;
  WeightGenerator generator(decode_tensors(read_file(path, 1 << 28), path), path);
  ELASTOGEN_CHECK(generator.hidden() == hidden_hash(hidden), path, " is for other hidden layers");
  return generator;
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

/// A way to begin, on hidden layers.
struct Way {
  std::string name;
  const std::vector<float>* hidden;
  const LastLayer* layer;
  MakeStart make_start;
};

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
      results.methods[w].courses.push_back(
          {passed.count(),
           fit_from(*way.layer, *way.hidden, material, start, kIterations, judged())});
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

void run(const Arguments& arguments) {
  const std::vector<float> hidden = read_hidden(arguments.folder);
  const std::optional<WeightGenerator> generator = read_generator(arguments, hidden);
  Results results;
  results.seed = arguments.seed, results.strains = kStrains;
  for (int64_t n = 0; n < arguments.count; ++n)
    results.materials.push_back(family_material(arguments.seed, uint64_t(n)));
  const MakeStart zero = [](const FitMaterial&, uint64_t) {
    return std::vector<float>(kMtlWidthOfLast);
  };
  const std::vector<float> drawn = drawn_hidden(arguments.seed);
  const LastLayer on_drawn(drawn), on_hidden(hidden);
  std::vector<Way> ways = {{"random hidden layers, zero", &drawn, &on_drawn, zero}};
  if (!generator) ways.push_back({name_of(Start::kZero), &hidden, &on_hidden, zero});
  for (const Start start : kStarts) {
    if (!generator || (start == Start::kDiffusion && !generator->has_denoiser())) continue;
    const MakeStart made = [&generator, start](const FitMaterial& material, uint64_t n) {
      return generator->last_layer(material, start, n);
    };
    ways.push_back({name_of(start), &hidden, &on_hidden, made});
  }
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
    elastogen::bench::run(elastogen::bench::arguments_of(argc, argv));
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "generation: {}\n", error.what());
    return 1;
  }
}
