// SPDX-License-Identifier: Apache-2.0
// How soon a net for a material never seen is good enough, by where its last layer begins: random
// materials, laws and mixtures of up to three at Poisson ratios up to 0.495, fitted for some
// iterations each (training/last_layer_fit.hpp) and judged on strains that no fit has seen.
//
//   generation FOLDER [COUNT [SEED]]   FOLDER: network/weights; prints a Markdown table

#include "core/error.hpp"
#include "io/safe_file.hpp"
#include "training/last_layer_fit.hpp"
#include "training/mtl_files.hpp"
#include "training/strain_sampler.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <random>

namespace elastogen::bench {
namespace {

constexpr int kIterations[] = {0, 1, 3, 10, 30, 80};
constexpr int64_t kStrains = 4000;  // of a report

using Layer = std::vector<float>;

std::string number(double value) {
  return fmt::format("{:.4f}", value);
}

/// A law or a sum of two or three, at a Poisson ratio uniform in 0 ... 0.495 or, half of them,
/// log-uniform in 1 - 2 nu.
FitMaterial random_material(std::mt19937_64& random) {
  std::array<std::string, 5> laws = {"fixed-corotated", "neo-hookean", "stable-neo-hookean", "stvk",
                                     "hencky"};
  std::uniform_real_distribution<double> uniform;
  std::shuffle(laws.begin(), laws.end(), random);
  const double first = 0.1 + 0.5 * uniform(random), second = 0.1 + 0.2 * uniform(random);
  const std::string a = number(first), b = number(second);
  std::string law = laws[0];
  switch (std::uniform_int_distribution<int>(0, 2)(random)) {
    case 1:
      law = fmt::format("{}*{}+{}*{}", a, laws[0], number(1 - std::stod(a)), laws[1]);
      break;
    case 2:
      law = fmt::format("{}*{}+{}*{}+{}*{}", a, laws[0], b, laws[1],
                        number(1 - std::stod(a) - std::stod(b)), laws[2]);
      break;
    default:
      break;
  }
  const double u = uniform(random);
  const bool even = uniform(random) < 0.5;
  return fit_material(law, std::stod(number(even ? 0.495 * u : (1 - std::pow(0.01, u)) / 2)));
}

/// Where a material lies among others: weights of the laws, and sqrt(2 mu/(3K)).
std::array<double, 6> features(const FitMaterial& material) {
  std::array<double, 6> x{};
  for (const LawTerm& term : material.terms) x[size_t(term.law.kind)] += term.weight;
  x[5] = std::sqrt((1 - 2 * material.poisson) / (1 + material.poisson));
  return x;
}

double distance(const FitMaterial& a, const FitMaterial& b) {
  const auto x = features(a), y = features(b);
  double sum = 0;
  for (size_t k = 0; k < x.size(); ++k) sum += (x[k] - y[k]) * (x[k] - y[k]);
  return sum;
}

/// A shipped material and its last layer.
struct Known {
  FitMaterial material;
  Layer last;
};

std::vector<Known> shipped(const std::string& folder) {
  std::vector<Known> all;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".weights") continue;
    const TensorFile file = decode_tensors(read_file(entry.path(), 1 << 24), entry.path());
    const std::vector<float>& w = file.get("neural_mtl", {kMtlParameters}).values;
    all.push_back({fit_material(file.text.at("law"), std::stod(file.text.at("poisson"))),
                   {w.end() - kMtlLast, w.end() - 1}});
  }
  return all;
}

/// What fits of some iterations came to: errors and times of each.
struct Row {
  int inside = 0;
  std::vector<double> median, p99, ms;
};

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values[values.size() / 2];
}

double largest(const std::vector<double>& values) {
  return *std::max_element(values.begin(), values.end());
}

/// Fits all materials for some iterations.
Row fit_all(const std::vector<FitMaterial>& materials, const std::vector<float>& hidden,
            const std::vector<Layer>& from, int iterations) {
  LastLayerOptions options;
  options.iterations = std::max(iterations, 1);
  const LastLayer layer(hidden, options);
  ReportOptions judged;
  judged.strains = kStrains;
  Row row;
  for (size_t n = 0; n < materials.size(); ++n) {
    const auto begin = std::chrono::steady_clock::now();
    std::vector<float> weights = hidden;
    if (iterations > 0)
      weights = layer.fit(materials[n], from[n]).weights;
    else
      std::copy(from[n].begin(), from[n].end(), weights.end() - kMtlLast);
    const std::chrono::duration<double, std::milli> passed =
        std::chrono::steady_clock::now() - begin;
    const FitReport report = fit_report(materials[n], weights, judged);
    row.inside += report.passes();
    row.median.push_back(report.stress_median);
    row.p99.push_back(report.stress_p99);
    row.ms.push_back(iterations > 0 ? passed.count() : 0);
  }
  return row;
}

void print_rows(const std::string& name, const std::vector<FitMaterial>& materials,
                const std::vector<float>& hidden, const std::vector<Layer>& from) {
  for (const int iterations : kIterations) {
    const Row row = fit_all(materials, hidden, from, iterations);
    fmt::print("| {} | {} | {:.1f} % | {:.2g} | {:.2g} | {:.2g} | {:.0f} |\n", name, iterations,
               100.0 * row.inside / double(materials.size()), 100 * median(row.median),
               100 * median(row.p99), 100 * largest(row.p99), median(row.ms));
    std::fflush(stdout);
  }
}

void run(const std::string& folder, int count, uint64_t seed) {
  const std::vector<Known> known = shipped(folder);
  ELASTOGEN_CHECK(!known.empty(), folder, " has no weights");
  const std::string place = folder + "/hidden.tensors";
  const std::vector<float> hidden =
      decode_tensors(read_file(place, 1 << 24), place).get("neural_mtl", {kMtlParameters}).values;
  std::mt19937_64 random(seed);
  std::vector<FitMaterial> materials;
  std::vector<Layer> nearest;
  for (int n = 0; n < count; ++n) {
    materials.push_back(random_material(random));
    const auto next =
        std::min_element(known.begin(), known.end(), [&](const auto& a, const auto& b) {
          return distance(a.material, materials.back()) < distance(b.material, materials.back());
        });
    nearest.push_back(next->last);
  }
  std::vector<float> drawn;  // as training/fit_neural_mtl.hpp begins
  for (int64_t k = 0; k < kMtlParameters; ++k)
    drawn.push_back(
        float((2 * counted_uniform(seed, 1, uint64_t(k)) - 1) / std::sqrt(k < 512 ? 3.0 : 128.0)));
  const std::vector<Layer> zero(materials.size(), Layer(kMtlLast - 1));
  fmt::print(
      "| begins at | iterations | inside all limits | stress, median net: median [%] | p99 [%] "
      "| worst net: p99 [%] | fit [ms] |\n|---|---|---|---|---|---|---|\n");
  print_rows("random hidden layers, last 0", materials, drawn, zero);
  print_rows("shipped hidden layers, last 0", materials, hidden, zero);
  print_rows("nearest shipped net", materials, hidden, nearest);
}

}  // namespace
}  // namespace elastogen::bench

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: generation FOLDER [COUNT [SEED]]\n");
    return 2;
  }
  try {
    elastogen::bench::run(argv[1], argc > 2 ? std::atoi(argv[2]) : 200,
                          argc > 3 ? std::strtoull(argv[3], nullptr, 10) : 1);
    return 0;
  } catch (const std::exception& error) {
    fmt::print(stderr, "generation: {}\n", error.what());
    return 1;
  }
}
